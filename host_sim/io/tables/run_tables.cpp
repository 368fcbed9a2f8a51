// SPDX-License-Identifier: MIT
#include "io/tables/run_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "io/tables/fixed_text.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {

std::int64_t firmware_cycle(const EngineFile &engine, std::int64_t cycle, std::size_t lane) {
    const double pitch_deg = 360.0 / engine.wheel.positions;
    const double since_deg = 720 * double(cycle) + engine.firing_tdc_deg[lane] - engine.position_0_deg;
    const double first_tooth = std::ceil(since_deg / pitch_deg - 1e-9);
    return std::int64_t(std::floor(first_tooth / (2 * engine.wheel.positions)));
}

std::int64_t ended_cycle(const EngineFile &engine, double crank_deg) {
    return std::int64_t(std::floor((crank_deg - engine.position_0_deg + 180) / 720)) - 1;
}

void RunTables::tooth(const EncoderEdge &truth, const EcuSaid &ecu) {
    const sd_signals_t &s = ecu.signals();
    const bool placed = is_placed(s);
    const std::uint8_t torque_health = ecu.health(SD_OWNER_TORQUE), firing_health = ecu.health(SD_OWNER_FIRING);
    const auto number = [this](double value, int decimals) { append_fixed(teeth_, value, decimals); };
    number(truth.time_s, 9);
    teeth_ += ',';
    number(truth.angle_deg, 4);
    teeth_ += ',';
    number(truth.speed_radps / kRadpsPerRpm, 3);
    teeth_ += ',';
    if (placed) number(double(s.crank_speed_rpm), 3);
    teeth_ += ',';
    number(truth.net_torque_nm, 3);
    teeth_ += ',';
    if (placed && torque_health != SD_INVALID) number(double(s.torque_mass_nm), 3);
    teeth_ += ',';
    teeth_ += class_name(s.crank_edge_class);
    teeth_ += ',';
    if (placed) number(double(s.crank_tooth), 0);
    teeth_ += ',';
    if (!truth.spurious) number(truth.tooth, 0);
    teeth_ += ',';
    teeth_ += health_name(ecu.health(SD_OWNER_CRANK));
    teeth_ += ',';
    teeth_ += health_name(torque_health);
    teeth_ += ',';
    if (placed && firing_health != SD_INVALID) number(double(s.firing_waveform_nm), 3);
    teeth_ += ',';
    teeth_ += health_name(firing_health);
    teeth_ += '\n';
}

void RunTables::note_work(double crank_deg, const EcuSaid &ecu) {
    const sd_signals_t &s = ecu.signals();
    const auto lane = std::size_t(s.work_firing);
    if (ecu.health(SD_OWNER_WORK) == SD_INVALID || lane >= engine_.firing_tdc_deg.size()) return;
    const auto cycle = std::int64_t(std::floor((crank_deg - engine_.firing_tdc_deg[lane]) / 720));
    works_said_[{cycle, lane}] = {double(s.work_cycle_j), double(s.work_sd_j),
                                  s.work_cylinder > 0.5f ? std::optional(double(s.work_change_j)) : std::nullopt};
}

void RunTables::edge(const EncoderEdge &truth, double crank_deg, const EcuSaid &ecu, bool cycle_ended) {
    const sd_signals_t &s = ecu.signals();
    if (ecu.firings() != firings_) {
        const int cylinder = int(s.firing_cylinder), verdict = int(s.misfire_verdict);
        verdicts_.said(crank_deg, cylinder, verdict, double(s.misfire_index));
        limits_.said(crank_deg, cylinder, verdict, double(s.misfire_limit));
        accelerations_.said(crank_deg, cylinder, verdict, double(s.misfire_acceleration_radps2));
        residuals_.said(crank_deg, cylinder, verdict, double(s.misfire_residual_radps2));
    }
    firings_ = ecu.firings();
    if (std::exchange(works_, ecu.works()) != ecu.works()) note_work(crank_deg, ecu);
    tooth(truth, ecu);
    if (cycle_ended) firmware_[ended_cycle(engine_, crank_deg)] = {s, ecu.health(SD_OWNER_CYLINDER), ecu.health(SD_OWNER_AFR)};
}

std::string RunTables::cycles_csv() const {
    std::string text = "cycle,cylinder,torque_true_nm,torque_nm,sd_nm,imep_true_bar,misfire_true,misfire_index,misfire_verdict,"
                       "misfire_acceleration,misfire_residual,rough,rpm,health,burned_true,burned,burned_sd,trim,t_s,"
                       "work_j,work_sd_j,work_change_j,misfire_limit\n";
    const auto number = [&text](double value, int decimals) { append_fixed(text, value, decimals); };
    for (const CycleTruth &truth : truths_) {
        const auto &order = engine_.firing_order;
        const auto lane = std::size_t(std::find(order.begin(), order.end(), truth.cylinder) - order.begin());
        const auto said = firmware_.find(firmware_cycle(engine_, truth.cycle, lane));
        const bool heard = said != firmware_.end();
        fmt::format_to(std::back_inserter(text), "{},{},", truth.cycle, truth.cylinder);
        number(truth.combustion_torque_nm, 3);
        text += ',';
        const bool told = heard && said->second.health != SD_INVALID;
        if (told) number(double(said->second.signals.cycle_cylinder_torque_nm[truth.cylinder - 1]), 3);
        text += ',';
        if (told) number(double(said->second.signals.cycle_cylinder_sd_nm[truth.cylinder - 1]), 4);
        text += ',';
        number(truth.imep_pa / kPaPerBar, 4);
        text += truth.misfire ? ",1," : ",0,";
        const auto *verdict = verdicts_.verdict(truth.cycle, truth.cylinder);
        if (verdict) number(verdict->second, 4);
        text += ',';
        if (verdict) number(verdict->first, 0);
        text += ',';
        if (verdict) number(accelerations_.verdict(truth.cycle, truth.cylinder)->second, 3);
        text += ',';
        if (verdict) number(residuals_.verdict(truth.cycle, truth.cylinder)->second, 3);
        text += ',';
        if (heard) number(int(said->second.signals.firing_rough), 0);
        text += ',';
        if (heard) number(double(said->second.signals.cycle_speed_rpm), 3);
        text += ',';
        text += health_name(heard ? said->second.health : std::uint8_t(SD_INVALID));
        text += ',';
        if (truth.exhaust_lambda != 0) number(truth.exhaust_lambda, 5);
        text += ',';
        const bool mixture = heard && said->second.afr_health != SD_INVALID;
        if (mixture) number(double(said->second.signals.afr_cylinder_burned[truth.cylinder - 1]), 5);
        text += ',';
        if (mixture) number(double(said->second.signals.afr_cylinder_sd[truth.cylinder - 1]), 5);
        text += ',';
        if (heard) number(double(said->second.signals.balance_trim[truth.cylinder - 1]), 5);
        text += ',';
        number(truth.tdc_time_s, 6);
        const auto work = works_said_.find({truth.cycle, lane});
        const bool worked = work != works_said_.end();
        text += ',';
        if (worked) number(work->second.cycle_j, 3);
        text += ',';
        if (worked) number(work->second.sd_j, 3);
        text += ',';
        if (worked && work->second.change_j) number(*work->second.change_j, 3);
        text += ',';
        if (verdict) number(limits_.verdict(truth.cycle, truth.cylinder)->second, 4);
        text += '\n';
    }
    return text;
}

} // namespace sixdeg
