// SPDX-License-Identifier: MIT
#include "plant/engine/engine_model.hpp"

#include <algorithm>
#include <cmath>

#include "plant/engine/gas.hpp"

namespace sixdeg {
namespace {

// G. Eichelberg, "Some new investigations on old combustion engine problems", Engineering 148 (1939):
// h = 2.1 c_m^(1/3) sqrt(p T) in kcal/(m2 h K) with p in kgf/cm2; the same in W/(m2 K) with p in Pa.
constexpr double kEichelberg = 7.80e-3;
// Below this the angle is no good variable to integrate over.
constexpr double kStallSpeed = 3;
// A pulse shorter than the first is rough throughout, and so is the beginning of any, rad.
constexpr double kShortPulse = 20 * kRadPerDeg, kOnset = 4 * kRadPerDeg;

} // namespace

EngineModel::EngineModel(const PlantEngine &engine, const std::vector<CylinderSpread> &spread,
                         double step_deg)
    : tables_(engine, spread, step_deg), n_(engine.shared.cylinders()), physical_(engine.shared.firing_order),
      pulse_shapes_(engine.pulses), crankcase_pa_(engine.crankcase_pressure_pa),
      exhaust_pa_(engine.exhaust_pressure_pa), charge_k_(engine.charge_temperature_k),
      exchange_(engine.exchange_per_rad), heating_value_(engine.heating_value_jpkg),
      stoichiometric_(engine.stoichiometric_ratio), wall_k_(engine.wall_temperature_k),
      wall_factor_(engine.wall_factor), cv_(engine.gas_cv_over_r), stroke_m_(engine.shared.stroke_m),
      displacement_m3_(engine.slider(engine.shared.compression_ratio).displacement_m3()),
      dual_mass_(engine.dual_mass),
      secondary_inertia_(engine.driveline_inertia_kgm2 +
                         (dual_mass_ ? dual_mass_->secondary_inertia_kgm2 : 0)),
      stay_{std::exp(-exchange_ * tables_.step_rad / 2), std::exp(-exchange_ * tables_.step_rad)} {
    stall_j_ = 0.5 * tables_.inertia[0] * kStallSpeed * kStallSpeed;
    double per_speed = 1;
    for (int i = 0; i < 3; ++i) {
        friction_nm_[i] = engine.torque_of_mep_nm(engine.fmep_pa[i]) * per_speed;
        per_speed /= 1000 * kRadpsPerRpm;
    }
    intake_pa_.fill(engine.intake_pressure_pa.at(0));
}

void EngineModel::start(std::int64_t cycle, int step, double time_s, double speed_radps) {
    cycle_ = cycle, step_ = step;
    crank_ = Motion{};
    crank_.time = time_s;
    crank_.energy = 0.5 * tables_.inertia[std::size_t(2 * step)] * speed_radps * speed_radps;
    crank_.secondary = speed_radps;
    for (int lane = 0; lane < n_; ++lane) {
        const auto l = std::size_t(lane);
        mass_[l] = intake_pa_[l] * volume(lane) / (gas::kR * charge_k_);
        inhaling_[l] = shut_[lane] = false;
        lane_[lane].manifold = intake_pa_[l];
        lane_[lane].y = Twins{intake_pa_[l], intake_pa_[l]};
        lane_[lane].work = 0.5 * power_of(lane);
        lane_[lane].lost = lane_[lane].released = lane_[lane].heat = lane_[lane].peak = 0;
        lane_[lane].inverse_mr = 1 / (mass_[l] * gas::kR);
        running_[l] = CycleTruth{};
    }
    sort_lanes();
    const auto later = [&](const Event &event) { return event.step > step_; };
    next_event_ = std::size_t(std::find_if(tables_.events.begin(), tables_.events.end(), later) -
                              tables_.events.begin());
    first_event_ = next_event_;
    point_at_next_event();
    set_mean_speed(speed_radps);
    evaluate_here();
    gas_before_nm_ = truth().gas_torque_nm, load_before_nm_ = friction_and_load_nm_;
}

void EngineModel::prescribe_speed(double speed_radps, double slope_radps2) {
    prescribed_ = true;
    speed0_ = speed_radps, speed_slope_ = slope_radps2, speed_time_ = crank_.time;
    crank_.energy = 0.5 * tables_.inertia[std::size_t(2 * step_)] * speed_radps * speed_radps;
    crank_.secondary = speed_radps;
    evaluate_here();
}

void EngineModel::release_speed() {
    prescribed_ = false;
    evaluate_here();
}

void EngineModel::set_time(double time_s) {
    for (CycleTruth &cycle : running_) cycle.tdc_time_s += time_s - crank_.time;
    crank_.time = load_time_ = speed_time_ = time_s;
    evaluate_here();
}

void EngineModel::set_load(double torque_nm, double slope_nmps) {
    load_nm_ = torque_nm, load_slope_ = slope_nmps, load_time_ = crank_.time;
    evaluate_here();
}

void EngineModel::set_intake_pressure(int lane, double pressure_pa) {
    const auto l = std::size_t(lane);
    intake_pa_[l] = pressure_pa;
    if (inhaling_[l]) lane_[lane].manifold = pressure_pa;
}

void EngineModel::set_mean_speed(double speed_radps) {
    wall_speed_ = wall_factor_ * kEichelberg * std::cbrt(stroke_m_ * speed_radps / kPi);
    for (int lane = 0; lane < n_; ++lane) lane_[lane].wall_factor = lane_[lane].wall_gain * wall_speed_;
    for (int i = 0; i < shut_count_; ++i) {
        lane_[lanes_[i]].calm = 0;
        find_change(lanes_[i]);
    }
}

void EngineModel::set_charge(int lane, const Charge &charge) {
    const auto l = std::size_t(lane);
    CycleTruth &cycle = running_[l];
    cycle.fuel_kg = charge.fuel_kg;
    cycle.air_kg = mass_[l];
    cycle.burned_fraction = charge.burned_fraction;
    cycle.misfire = charge.burned_fraction < 0.5;
    const double could_burn = std::min(charge.fuel_kg, mass_[l] / stoichiometric_);
    const double heat = heating_value_ * could_burn * charge.burned_fraction * charge.heat_factor;
    Burn &burn = lane_[lane].burn;
    burn.heat_j = heat;
    lane_[lane].released = 0;
    if (burn.points.empty() || burn.start_shift_rad != charge.start_shift_rad || burn.duration_factor != charge.duration_factor)
        lay_burn(lane, charge);
    const double start = theta(2 * step_, lane), from = burn.from_rad;
    burn.at = heat > 0 ? -int(std::floor((from - start) / tables_.step_rad)) : kNeverBurns;
}

/// Heat of every step from the one in which the first pulse begins to the one in which the last ends.
void EngineModel::lay_burn(int lane, const Charge &charge) {
    Burn &burn = lane_[lane].burn;
    burn.start_shift_rad = charge.start_shift_rad, burn.duration_factor = charge.duration_factor;
    std::vector<WiebePulse> pulses;
    double from = 1e9, to = -1e9;
    for (const PulseShape &shape : pulse_shapes_) {
        pulses.push_back({shape.start_rad + charge.start_shift_rad, shape.duration_rad * charge.duration_factor, shape.shape_m,
                          shape.share});
        from = std::min(from, pulses.back().start_rad), to = std::max(to, pulses.back().end_rad());
    }
    burn.from_rad = from;
    burn.points.clear();
    const double h = tables_.step_rad, start = theta(2 * step_, lane);
    for (double at = start + h * std::floor((from - start) / h); at < to; at += h) {
        BurnPoint point{0, 0, 0, false};
        double unused = 0;
        for (const WiebePulse &pulse : pulses) {
            const double rough_to = pulse.duration_rad < kShortPulse ? pulse.end_rad() : pulse.start_rad + kOnset;
            point.rough |= at + h > pulse.start_rad && at < rough_to;
            pulse.add(at + h, point.rate, point.released);
            pulse.add(at + h / 2, point.rate_middle, unused);
        }
        burn.points.push_back(point);
    }
    burn.end = int(burn.points.size());
}

void EngineModel::evaluate_here() {
    crank_.speed = prescribed_ ? speed0_ + speed_slope_ * (crank_.time - speed_time_)
                               : std::sqrt(crank_.energy * tables_.two_over_inertia[std::size_t(2 * step_)]);
    crank_.slowness = 1 / crank_.speed;
    for (int i = 0; i < shut_count_; ++i) find_change(lanes_[i]);
    const double load = friction_and_load_nm_;
    update_truth(power_here());
    load_before_nm_ += friction_and_load_nm_ - load;
}

void EngineModel::sort_lanes() {
    shut_count_ = 0;
    for (int lane = 0; lane < n_; ++lane) {
        if (shut_[lane]) lanes_[shut_count_++] = lane;
    }
    for (int lane = 0, place = shut_count_; lane < n_; ++lane) {
        if (!shut_[lane]) lanes_[place++] = lane;
    }
}

void EngineModel::take_events() {
    while (next_event_ < tables_.events.size() && tables_.events[next_event_].step == step_) {
        apply(tables_.events[next_event_++]);
    }
    point_at_next_event();
}

void EngineModel::point_at_next_event() {
    next_event_step_ = next_event_ < tables_.events.size() ? tables_.events[next_event_].step : -1;
}

void EngineModel::apply(const Event &event) {
    const int lane = event.lane;
    const auto l = std::size_t(lane);
    switch (event.kind) {
    case EventKind::intake_close:
        shut(lane);
        break;
    case EventKind::tdc:
        running_[l].cycle = cycle_;
        running_[l].tdc_time_s = crank_.time;
        running_[l].tdc_speed_radps = crank_.speed;
        work_at_tdc_[l] = work_of_fuel_j(lane);
        break;
    case EventKind::half_turn:
        running_[l].combustion_torque_nm = (work_of_fuel_j(lane) - work_at_tdc_[l]) / kPi;
        break;
    case EventKind::exhaust_open:
        lane_[lane].y = pressure_of(lane);
        shut_[lane] = false;
        sort_lanes();
        lane_[lane].manifold = exhaust_pa_;
        break;
    case EventKind::exchange:
        inhaling_[l] = true;
        lane_[lane].manifold = intake_pa_[l];
        finish_cycle(lane);
        break;
    }
}

void EngineModel::shut(int lane) {
    const auto l = std::size_t(lane);
    inhaling_[l] = false;
    const double pressure = lane_[lane].y[0];
    lane_[lane].work[1] += 0.5 * (pressure - lane_[lane].y[1]) * here(lane).volume_slope; // the twin's p V' jumps
    lane_[lane].y = Twins{pressure, pressure} / here(lane).pressure;
    mass_[l] = pressure * volume(lane) / (gas::kR * charge_k_);
    shut_[lane] = true;
    sort_lanes();
    lane_[lane].inverse_mr = 1 / (mass_[l] * gas::kR);
    lane_[lane].wall_gain = std::sqrt(lane_[lane].inverse_mr);
    lane_[lane].wall_factor = lane_[lane].wall_gain * wall_speed_;
    lane_[lane].calm = 0, lane_[lane].heat = 0, lane_[lane].peak = 0;
    set_charge(lane, Charge{});
    find_change(lane);
}

void EngineModel::finish_cycle(int lane) {
    const auto l = std::size_t(lane);
    CycleTruth &cycle = running_[l];
    cycle.cylinder = physical_[l];
    cycle.work_j = work_j(lane);
    cycle.imep_pa = cycle.work_j / displacement_m3_;
    cycle.combustion_work_j = work_of_fuel_j(lane);
    cycle.wall_loss_j = lane_[lane].lost;
    cycle.heat_j = lane_[lane].released;
    cycle.peak_pressure_pa = lane_[lane].peak;
    finished_[l] = cycle;
    cycle = CycleTruth{};
    lane_[lane].work = 0.5 * power_of(lane);
    lane_[lane].lost = 0;
}

} // namespace sixdeg
