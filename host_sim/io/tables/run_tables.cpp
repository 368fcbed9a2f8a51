// SPDX-License-Identifier: MIT
#include "io/tables/run_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

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
    const std::uint8_t torque_health = ecu.health(SD_OWNER_TORQUE);
    const auto out = std::back_inserter(teeth_);
    fmt::format_to(out, "{:.9f},{:.4f},{:.3f},", truth.time_s, truth.angle_deg,
                   truth.speed_radps / kRadpsPerRpm);
    if (placed) fmt::format_to(out, "{:.3f}", s.crank_speed_rpm);
    fmt::format_to(out, ",{:.3f},", truth.net_torque_nm);
    if (placed && torque_health != SD_INVALID) fmt::format_to(out, "{:.3f}", s.torque_mass_nm);
    fmt::format_to(out, ",{},", class_name(s.crank_edge_class));
    if (placed) fmt::format_to(out, "{:.0f}", s.crank_tooth);
    teeth_ += ',';
    if (!truth.spurious) fmt::format_to(out, "{}", truth.tooth);
    fmt::format_to(out, ",{},{}\n", health_name(ecu.health(SD_OWNER_CRANK)), health_name(torque_health));
}

void RunTables::edge(const EncoderEdge &truth, double crank_deg, const EcuSaid &ecu, bool cycle_ended) {
    const sd_signals_t &s = ecu.signals();
    if (ecu.firings() != firings_) verdicts_.said(crank_deg, int(s.firing_cylinder), int(s.misfire_verdict), double(s.misfire_index));
    firings_ = ecu.firings();
    tooth(truth, ecu);
    if (cycle_ended) firmware_[ended_cycle(engine_, crank_deg)] = {s, ecu.health(SD_OWNER_CYLINDER), ecu.health(SD_OWNER_AFR)};
}

std::string RunTables::cycles_csv() const {
    std::string text = "cycle,cylinder,torque_true_nm,torque_nm,sd_nm,imep_true_bar,misfire_true,misfire_index,misfire_verdict,"
                       "rough,rpm,health,burned_true,burned,burned_sd,trim,t_s\n";
    const auto out = std::back_inserter(text);
    for (const CycleTruth &truth : truths_) {
        const auto &order = engine_.firing_order;
        const auto lane = std::size_t(std::find(order.begin(), order.end(), truth.cylinder) - order.begin());
        const auto said = firmware_.find(firmware_cycle(engine_, truth.cycle, lane));
        const bool heard = said != firmware_.end();
        fmt::format_to(out, "{},{},{:.3f},", truth.cycle, truth.cylinder, truth.combustion_torque_nm);
        const bool told = heard && said->second.health != SD_INVALID;
        if (told) fmt::format_to(out, "{:.3f}", said->second.signals.cycle_cylinder_torque_nm[truth.cylinder - 1]);
        text += ',';
        if (told) fmt::format_to(out, "{:.4f}", said->second.signals.cycle_cylinder_sd_nm[truth.cylinder - 1]);
        fmt::format_to(out, ",{:.4f},{},", truth.imep_pa / kPaPerBar, int(truth.misfire));
        if (const auto *verdict = verdicts_.verdict(truth.cycle, truth.cylinder))
            fmt::format_to(out, "{:.4f},{},", verdict->second, verdict->first);
        else
            text += ",,";
        if (heard) fmt::format_to(out, "{}", int(said->second.signals.firing_rough));
        text += ',';
        if (heard) fmt::format_to(out, "{:.3f}", said->second.signals.cycle_speed_rpm);
        fmt::format_to(out, ",{},", health_name(heard ? said->second.health : std::uint8_t(SD_INVALID)));
        if (truth.exhaust_lambda != 0) fmt::format_to(out, "{:.5f}", truth.exhaust_lambda);
        text += ',';
        const bool mixture = heard && said->second.afr_health != SD_INVALID;
        if (mixture) fmt::format_to(out, "{:.5f}", said->second.signals.afr_cylinder_burned[truth.cylinder - 1]);
        text += ',';
        if (mixture) fmt::format_to(out, "{:.5f}", said->second.signals.afr_cylinder_sd[truth.cylinder - 1]);
        text += ',';
        if (heard) fmt::format_to(out, "{:.5f}", said->second.signals.balance_trim[truth.cylinder - 1]);
        fmt::format_to(out, ",{:.6f}\n", truth.tdc_time_s);
    }
    return text;
}

} // namespace sixdeg
