// SPDX-License-Identifier: MIT
#include "plant/engine/engine_model.hpp"

#include <algorithm>
#include <cmath>

#include "plant/engine/gas.hpp"

// Inlines every call within: one step is a few hundred instructions, and the calls cost a third of them.
#define SD_FLATTEN __attribute__((flatten))

namespace sixdeg {
namespace {

// G. Eichelberg, "Some new investigations on old combustion engine problems", Engineering 148 (1939):
// h = 2.1 c_m^(1/3) sqrt(p T) in kcal/(m2 h K) with p in kgf/cm2; the same in W/(m2 K) with p in Pa.
constexpr double kEichelberg = 7.80e-3;
// Below this the angle is no good variable to integrate over.
constexpr double kStallSpeed = 3;

} // namespace

EngineModel::EngineModel(const PlantEngine &engine, const std::vector<CylinderSpread> &spread,
                         double step_deg)
    : tables_(engine, spread, step_deg), n_(engine.shared.cylinders()), physical_(engine.shared.firing_order),
      pulse_shapes_(engine.pulses), crankcase_pa_(engine.crankcase_pressure_pa),
      exhaust_pa_(engine.exhaust_pressure_pa), charge_k_(engine.charge_temperature_k),
      exchange_(engine.exchange_per_rad), heating_value_(engine.heating_value_jpkg),
      stoichiometric_(engine.stoichiometric_ratio), wall_k_(engine.wall_temperature_k),
      wall_factor_(engine.wall_factor), stroke_m_(engine.shared.stroke_m),
      displacement_m3_(engine.slider(engine.shared.compression_ratio).displacement_m3()),
      dual_mass_(engine.dual_mass),
      secondary_inertia_(engine.driveline_inertia_kgm2 +
                         (dual_mass_ ? dual_mass_->secondary_inertia_kgm2 : 0)) {
    double per_speed = 1;
    for (int i = 0; i < 3; ++i) {
        friction_nm_[i] = engine.torque_of_mep_nm(engine.fmep_pa[i]) * per_speed;
        per_speed /= 1000 * kRadpsPerRpm;
    }
    intake_pa_.fill(engine.intake_pressure_pa.at(0));
}

void EngineModel::start(std::int64_t cycle, int step, double time_s, double speed_radps) {
    cycle_ = cycle, step_ = step;
    state_ = State{};
    state_.crank.time = time_s;
    state_.crank.energy = 0.5 * tables_.inertia[std::size_t(2 * step)] * speed_radps * speed_radps;
    state_.crank.secondary = speed_radps;
    for (int lane = 0; lane < n_; ++lane) {
        const auto l = std::size_t(lane);
        mass_[l] = intake_pa_[l] * volume(lane) / (gas::kR * charge_k_);
        inhaling_[l] = shut_[lane] = burns_[l] = false;
        manifold_[lane] = intake_pa_[l];
        state_.p[lane] = Twins{intake_pa_[l], intake_pa_[l]};
        inverse_mr_[lane] = 1 / (mass_[l] * gas::kR);
        running_[l] = CycleTruth{};
    }
    sort_lanes();
    for (auto &rates : heat_) std::fill(std::begin(rates), std::end(rates), 0.0);
    const auto later = [&](const Event &event) { return event.step > step_; };
    next_event_ = std::size_t(std::find_if(tables_.events.begin(), tables_.events.end(), later) -
                              tables_.events.begin());
    first_event_ = next_event_;
    set_mean_speed(speed_radps);
    evaluate_here();
}

void EngineModel::prescribe_speed(double speed_radps, double slope_radps2) {
    prescribed_ = true;
    speed0_ = speed_radps, speed_slope_ = slope_radps2, speed_time_ = state_.crank.time;
    state_.crank.energy = 0.5 * tables_.inertia[std::size_t(2 * step_)] * speed_radps * speed_radps;
    state_.crank.secondary = speed_radps;
    evaluate_here();
}

void EngineModel::release_speed() {
    prescribed_ = false;
    evaluate_here();
}

void EngineModel::set_time(double time_s) {
    for (CycleTruth &cycle : running_) cycle.tdc_time_s += time_s - state_.crank.time;
    state_.crank.time = load_time_ = speed_time_ = time_s;
    evaluate_here();
}

void EngineModel::set_load(double torque_nm, double slope_nmps) {
    load_nm_ = torque_nm, load_slope_ = slope_nmps, load_time_ = state_.crank.time;
    evaluate_here();
}

void EngineModel::set_intake_pressure(int lane, double pressure_pa) {
    const auto l = std::size_t(lane);
    intake_pa_[l] = pressure_pa;
    if (inhaling_[l]) manifold_[lane] = pressure_pa;
}

void EngineModel::set_mean_speed(double speed_radps) {
    wall_speed_ = wall_factor_ * kEichelberg * std::cbrt(stroke_m_ * speed_radps / kPi);
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
    burns_[l] = heat > 0;
    released_[l] = 0;
    burn_from_[l] = 1e9, burn_to_[l] = -1e9;
    burning_[l] = {};
    for (std::size_t i = 0; i < pulse_shapes_.size(); ++i) {
        const PulseShape &shape = pulse_shapes_[i];
        WiebePulse &pulse = burning_[l][i];
        pulse = {shape.start_rad + charge.start_shift_rad, shape.duration_rad * charge.duration_factor,
                 shape.shape_m, shape.share * heat};
        burn_from_[l] = std::min(burn_from_[l], pulse.start_rad);
        burn_to_[l] = std::max(burn_to_[l], pulse.end_rad());
    }
}

double EngineModel::theta(int half, int lane) const {
    const double angle = half * (tables_.step_rad / 2) - tables_.tdc_rad[std::size_t(lane)];
    return angle > 2 * kPi ? angle - 4 * kPi : angle;
}

void EngineModel::heat_rates(int half, double *rates) const {
    for (int i = 0; i < shut_count_; ++i) {
        const int lane = lanes_[i];
        const auto l = std::size_t(lane);
        rates[lane] = 0;
        if (!burns_[l]) continue;
        const double at = theta(half, lane);
        if (at <= burn_from_[l] || at >= burn_to_[l]) continue;
        for (std::size_t pulse = 0; pulse < pulse_shapes_.size(); ++pulse) rates[lane] += burning_[l][pulse].rate(at);
    }
}

double EngineModel::speed_at(int half, const Motion &at) const {
    if (prescribed_) return speed0_ + speed_slope_ * (at.time - speed_time_);
    return std::sqrt(at.energy * tables_.two_over_inertia[std::size_t(half)]);
}

bool EngineModel::stands_still(const Motion &at) const {
    const double smallest = 0.5 * tables_.inertia[0] * kStallSpeed * kStallSpeed;
    // Written so that NaN stands still too.
    return !(prescribed_ ? speed0_ + speed_slope_ * (at.time - speed_time_) > 0 : at.energy > smallest);
}

void EngineModel::shut_cylinder(int half, int lane, double inv_speed, double heat, const State &at, State &slope) const {
    const auto point = std::size_t(half * tables_.width + lane);
    const double volume = tables_.volume[point], wall = tables_.wall[point] * (wall_speed_ * inv_speed);
    const Twins p = at.p[lane];
    const Twins t = p * volume * inverse_mr_[lane];
    const Twins cv = gas::kB0 + t * (gas::kB1 + t * gas::kB2);
    const Twins power = p * tables_.volume_slope[point];
    const Twins loss = wall_gain_[lane] * wall * p * (t - wall_k_);
    slope.p[lane] = (Twins{heat, 0} - loss - (cv + 1) * power) / (cv * volume);
    slope.work[lane] = power;
    slope.wall[lane] = loss;
}

// The hot loop. Only shut cylinders need the gas law; an open one follows its manifold.
void EngineModel::evaluate(int half, const State &at, const double *heat, State &slope, Totals &totals) const {
    const double speed = speed_at(half, at.crank), inv_speed = 1 / speed;
    for (int i = shut_count_; i < n_; ++i) {
        const int lane = lanes_[i];
        slope.p[lane] = exchange_ * (manifold_[lane] - at.p[lane]);
        slope.work[lane] = at.p[lane] * tables_.volume_slope[std::size_t(half * tables_.width + lane)];
    }
    for (int i = 0; i < shut_count_; ++i) shut_cylinder(half, lanes_[i], inv_speed, heat[lanes_[i]], at, slope);
    Twins gas = {0, 0};
    for (int lane = 0; lane < n_; ++lane) gas += slope.work[lane];
    totals.fired = gas[0], totals.motored = gas[1];
    totals.gas = gas[0] - crankcase_pa_ * tables_.volume_slope_sum[std::size_t(half)];
    totals.speed = speed;
    const double friction = friction_nm_[0] + speed * (friction_nm_[1] + speed * friction_nm_[2]);
    const double load = load_nm_ + load_slope_ * (at.crank.time - load_time_);
    double carried = load;
    slope.crank.twist = slope.crank.secondary = 0;
    if (dual_mass_ && !prescribed_) {
        const double lead = speed - at.crank.secondary;
        carried = dual_mass_->stiffness_nmprad * at.crank.twist + dual_mass_->damping_nmsprad * lead;
        slope.crank.twist = lead * inv_speed;
        slope.crank.secondary = (carried - load) / secondary_inertia_ * inv_speed;
    }
    totals.load = friction + carried;
    slope.crank.energy = prescribed_ ? 0 : totals.gas - totals.load;
    slope.crank.time = inv_speed;
}

// What other slopes depend on; work and wall loss are integrals only and wait for commit().
void EngineModel::add(const State &base, double h, const State &slope, State &sum) const {
    for (int lane = 0; lane < n_; ++lane) sum.p[lane] = base.p[lane] + h * slope.p[lane];
    sum.crank.energy = base.crank.energy + h * slope.crank.energy;
    sum.crank.time = base.crank.time + h * slope.crank.time;
    sum.crank.twist = base.crank.twist + h * slope.crank.twist;
    sum.crank.secondary = base.crank.secondary + h * slope.crank.secondary;
}

void EngineModel::commit(const State &k2, const State &k3, const State &k4) {
    const double h = tables_.step_rad / 6;
    const auto step = [h](auto &y, const auto &a, const auto &b, const auto &c, const auto &d) {
        y += h * (a + 2 * (b + c) + d);
    };
    for (int lane = 0; lane < n_; ++lane) {
        step(state_.p[lane], slope_.p[lane], k2.p[lane], k3.p[lane], k4.p[lane]);
        step(state_.work[lane], slope_.work[lane], k2.work[lane], k3.work[lane], k4.work[lane]);
        peak_[lane] = std::max(peak_[lane], state_.p[lane][0]);
    }
    for (int i = 0; i < shut_count_; ++i) {
        const int lane = lanes_[i];
        step(state_.wall[lane], slope_.wall[lane], k2.wall[lane], k3.wall[lane], k4.wall[lane]);
        released_[lane] += h * (heat_[0][lane] + 4 * heat_[1][lane] + heat_[2][lane]);
        heat_[0][lane] = heat_[2][lane];
    }
    const Motion &a = slope_.crank, &b = k2.crank, &c = k3.crank, &d = k4.crank;
    step(state_.crank.energy, a.energy, b.energy, c.energy, d.energy);
    step(state_.crank.time, a.time, b.time, c.time, d.time);
    if (!dual_mass_) return;
    step(state_.crank.twist, a.twist, b.twist, c.twist, d.twist);
    step(state_.crank.secondary, a.secondary, b.secondary, c.secondary, d.secondary);
}

SD_FLATTEN bool EngineModel::step() {
    const double h = tables_.step_rad;
    const int middle = 2 * step_ + 1, end = 2 * step_ + 2, end_point = end == 2 * tables_.steps ? 0 : end;
    heat_rates(middle, heat_[1]);
    heat_rates(end, heat_[2]);
    State at, k2, k3, k4;
    Totals unused;
    add(state_, h / 2, slope_, at);
    if (stands_still(at.crank)) return false;
    evaluate(middle, at, heat_[1], k2, unused);
    add(state_, h / 2, k2, at);
    if (stands_still(at.crank)) return false;
    evaluate(middle, at, heat_[1], k3, unused);
    add(state_, h, k3, at);
    if (stands_still(at.crank)) return false;
    evaluate(end_point, at, heat_[2], k4, unused);
    commit(k2, k3, k4);
    if (++step_ == tables_.steps) step_ = 0, next_event_ = 0, ++cycle_;
    take_events();
    evaluate(2 * step_, state_, heat_[0], slope_, totals_);
    update_truth();
    return true;
}

void EngineModel::evaluate_here() {
    if (prescribed_) { // keeps the energy at hand for the moment the crank is released
        const double speed = speed_at(2 * step_, state_.crank);
        state_.crank.energy = 0.5 * tables_.inertia[std::size_t(2 * step_)] * speed * speed;
    }
    evaluate(2 * step_, state_, heat_[0], slope_, totals_);
    update_truth();
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
    first_event_ = next_event_;
    while (next_event_ < tables_.events.size() && tables_.events[next_event_].step == step_) {
        apply(tables_.events[next_event_++]);
    }
}

void EngineModel::apply(const Event &event) {
    const int lane = event.lane;
    const auto l = std::size_t(lane);
    switch (event.kind) {
    case EventKind::intake_close:
        inhaling_[l] = false;
        state_.p[lane][1] = state_.p[lane][0];
        mass_[l] = state_.p[lane][0] * volume(lane) / (gas::kR * charge_k_);
        shut_[lane] = true;
        sort_lanes();
        inverse_mr_[lane] = 1 / (mass_[l] * gas::kR);
        wall_gain_[lane] = std::sqrt(inverse_mr_[lane]);
        peak_[lane] = 0;
        set_charge(lane, Charge{});
        break;
    case EventKind::tdc:
        running_[l].cycle = cycle_;
        running_[l].tdc_time_s = state_.crank.time;
        running_[l].tdc_speed_radps = speed_at(2 * step_, state_.crank);
        work_at_tdc_[l] = work_of_fuel_j(lane);
        break;
    case EventKind::half_turn:
        running_[l].combustion_torque_nm = (work_of_fuel_j(lane) - work_at_tdc_[l]) / kPi;
        break;
    case EventKind::exhaust_open:
        shut_[lane] = false;
        sort_lanes();
        manifold_[lane] = exhaust_pa_;
        for (auto &rates : heat_) rates[lane] = 0;
        burns_[l] = false;
        break;
    case EventKind::exchange:
        inhaling_[l] = true;
        manifold_[lane] = intake_pa_[l];
        finish_cycle(lane);
        break;
    }
}

void EngineModel::finish_cycle(int lane) {
    const auto l = std::size_t(lane);
    CycleTruth &cycle = running_[l];
    cycle.cylinder = physical_[l];
    cycle.work_j = state_.work[lane][0];
    cycle.imep_pa = cycle.work_j / displacement_m3_;
    cycle.combustion_work_j = work_of_fuel_j(lane);
    cycle.wall_loss_j = state_.wall[lane][0];
    cycle.heat_j = released_[l];
    cycle.peak_pressure_pa = peak_[lane];
    finished_[l] = cycle;
    cycle = CycleTruth{};
    state_.work[lane] = state_.wall[lane] = Twins{0, 0};
}

void EngineModel::update_truth() {
    truth_.angle_rad = (double(cycle_) * tables_.steps + step_) * tables_.step_rad;
    truth_.time_s = state_.crank.time;
    truth_.speed_radps = totals_.speed;
    truth_.combustion_torque_nm = totals_.fired - totals_.motored;
    truth_.gas_torque_nm = totals_.gas;
    truth_.load_torque_nm = totals_.load;
    truth_.net_torque_nm = totals_.gas - totals_.load;
}

} // namespace sixdeg
