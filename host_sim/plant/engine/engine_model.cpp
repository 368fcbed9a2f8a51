// SPDX-License-Identifier: MIT
#include "plant/engine/engine_model.hpp"

#include <Eigen/Core>
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
constexpr int kTwins = kMaxCylinders;

// W neighbouring doubles as one array.
template <int W> using Lanes = Eigen::Array<double, W, 1>;
template <int W> Eigen::Map<const Lanes<W>> lanes(const double *first) {
    return Eigen::Map<const Lanes<W>>(first);
}
template <int W> Eigen::Map<Lanes<W>> lanes(double *first) { return Eigen::Map<Lanes<W>>(first); }

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
    state_.time = time_s;
    state_.energy = 0.5 * tables_.inertia[std::size_t(2 * step)] * speed_radps * speed_radps;
    state_.secondary = speed_radps;
    for (int lane = 0; lane < n_; ++lane) {
        const auto l = std::size_t(lane);
        mass_[l] = intake_pa_[l] * volume(lane) / (gas::kR * charge_k_);
        inhaling_[l] = false;
        for (int twin : {lane, lane + kTwins}) {
            state_.p[twin] = manifold_[twin] = intake_pa_[l];
            closed_[twin] = 0, open_[twin] = exchange_;
            inverse_mr_[twin] = 1 / (mass_[l] * gas::kR);
            wall_gain_[twin] = 0;
        }
        burns_[l] = false;
        running_[l] = CycleTruth{};
    }
    for (int i = 0; i < kLanes; ++i) state_.p[i] = state_.p[i] > 0 ? state_.p[i] : kPaPerBar; // idle columns
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
    speed0_ = speed_radps, speed_slope_ = slope_radps2, speed_time_ = state_.time;
    state_.energy = 0.5 * tables_.inertia[std::size_t(2 * step_)] * speed_radps * speed_radps;
    state_.secondary = speed_radps;
    evaluate_here();
}

void EngineModel::release_speed() {
    prescribed_ = false;
    evaluate_here();
}

void EngineModel::set_time(double time_s) {
    for (CycleTruth &cycle : running_) cycle.tdc_time_s += time_s - state_.time;
    state_.time = load_time_ = speed_time_ = time_s;
    evaluate_here();
}

void EngineModel::set_load(double torque_nm, double slope_nmps) {
    load_nm_ = torque_nm, load_slope_ = slope_nmps, load_time_ = state_.time;
    evaluate_here();
}

void EngineModel::set_intake_pressure(int lane, double pressure_pa) {
    const auto l = std::size_t(lane);
    intake_pa_[l] = pressure_pa;
    if (inhaling_[l]) manifold_[lane] = manifold_[lane + kTwins] = pressure_pa;
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
    for (int lane = 0; lane < n_; ++lane) {
        const auto l = std::size_t(lane);
        rates[lane] = 0;
        if (!burns_[l] || closed_[lane] == 0) continue;
        const double at = theta(half, lane);
        if (at <= burn_from_[l] || at >= burn_to_[l]) continue;
        for (std::size_t i = 0; i < pulse_shapes_.size(); ++i) rates[lane] += burning_[l][i].rate(at);
    }
}

double EngineModel::speed_at(int half, const State &at) const {
    if (prescribed_) return speed0_ + speed_slope_ * (at.time - speed_time_);
    return std::sqrt(at.energy * tables_.two_over_inertia[std::size_t(half)]);
}

bool EngineModel::stands_still(const State &at) const {
    const double smallest = 0.5 * tables_.inertia[0] * kStallSpeed * kStallSpeed;
    // Written so that NaN stands still too.
    return !(prescribed_ ? speed0_ + speed_slope_ * (at.time - speed_time_) > 0 : at.energy > smallest);
}

// The hot loop, over columns of cylinders at once: first those that fire, then their motored twins. Eight
// columns are taken as twice four, which the registers hold.
template <int W>
void EngineModel::cylinders(int half, const State &at, const double *heat, double inv_speed,
                            State &slope) const {
    constexpr int B = W == 8 ? 4 : W;
    for (int column = 0; column < W; column += B) {
        const auto point = std::size_t(half * W + column);
        const Lanes<B> volume = lanes<B>(&tables_.volume[point]),
                       volume_slope = lanes<B>(&tables_.volume_slope[point]);
        const Lanes<B> wall = lanes<B>(&tables_.wall[point]) * (wall_speed_ * inv_speed);
        for (int first : {column, column + kTwins}) {
            const Lanes<B> p = lanes<B>(at.p + first);
            const Lanes<B> t = p * volume * lanes<B>(inverse_mr_ + first);
            const Lanes<B> cv = gas::kB0 + t * (gas::kB1 + t * gas::kB2);
            const Lanes<B> power = p * volume_slope;
            const Lanes<B> loss = lanes<B>(wall_gain_ + first) * wall * p * (t - wall_k_);
            const Lanes<B> inside = (lanes<B>(heat + first) - loss - (cv + 1) * power) / (cv * volume);
            lanes<B>(slope.p + first) = lanes<B>(closed_ + first) * inside +
                                        lanes<B>(open_ + first) * (lanes<B>(manifold_ + first) - p);
            lanes<B>(slope.work + first) = power;
            lanes<B>(slope.wall + first) = loss;
        }
    }
}

template <int W>
void EngineModel::evaluate(int half, const State &at, const double *heat, State &slope,
                           Totals &totals) const {
    const double speed = speed_at(half, at), inv_speed = 1 / speed;
    cylinders<W>(half, at, heat, inv_speed, slope);
    double gas = 0;
    for (int i = 0; i < W; ++i) gas += slope.work[i];
    totals.gas = gas - crankcase_pa_ * tables_.volume_slope_sum[std::size_t(half)];
    totals.speed = speed;
    const double friction = friction_nm_[0] + speed * (friction_nm_[1] + speed * friction_nm_[2]);
    const double load = load_nm_ + load_slope_ * (at.time - load_time_);
    double carried = load;
    slope.twist = slope.secondary = 0;
    if (dual_mass_ && !prescribed_) {
        carried =
            dual_mass_->stiffness_nmprad * at.twist + dual_mass_->damping_nmsprad * (speed - at.secondary);
        slope.twist = (speed - at.secondary) * inv_speed;
        slope.secondary = (carried - load) / secondary_inertia_ * inv_speed;
    }
    totals.load = friction + carried;
    slope.energy = prescribed_ ? 0 : totals.gas - totals.load;
    slope.time = inv_speed;
}

// What other slopes depend on; work and wall loss are integrals only and wait for commit().
template <int W> void EngineModel::add(const State &base, double h, const State &slope, State &sum) const {
    for (int first : {0, kTwins})
        lanes<W>(sum.p + first) = lanes<W>(base.p + first) + h * lanes<W>(slope.p + first);
    sum.energy = base.energy + h * slope.energy;
    sum.time = base.time + h * slope.time;
    sum.twist = base.twist + h * slope.twist;
    sum.secondary = base.secondary + h * slope.secondary;
}

template <int W> void EngineModel::commit(const State &k2, const State &k3, const State &k4) {
    const double h = tables_.step_rad / 6;
    const auto step = [h](double &y, double a, double b, double c, double d) {
        y += h * (a + 2 * (b + c) + d);
    };
    const auto step_lanes = [h](double *y, const double *a, const double *b, const double *c,
                                const double *d) {
        lanes<W>(y) += h * (lanes<W>(a) + 2 * (lanes<W>(b) + lanes<W>(c)) + lanes<W>(d));
    };
    for (int first : {0, kTwins}) {
        step_lanes(state_.p + first, slope_.p + first, k2.p + first, k3.p + first, k4.p + first);
        step_lanes(state_.work + first, slope_.work + first, k2.work + first, k3.work + first,
                   k4.work + first);
        step_lanes(state_.wall + first, slope_.wall + first, k2.wall + first, k3.wall + first,
                   k4.wall + first);
    }
    lanes<W>(released_) += h * (lanes<W>(heat_[0]) + 4 * lanes<W>(heat_[1]) + lanes<W>(heat_[2]));
    lanes<W>(peak_) = lanes<W>(peak_).max(lanes<W>(state_.p));
    step(state_.energy, slope_.energy, k2.energy, k3.energy, k4.energy);
    step(state_.time, slope_.time, k2.time, k3.time, k4.time);
    step(state_.twist, slope_.twist, k2.twist, k3.twist, k4.twist);
    step(state_.secondary, slope_.secondary, k2.secondary, k3.secondary, k4.secondary);
}

template <int W> SD_FLATTEN bool EngineModel::step_width() {
    const double h = tables_.step_rad;
    const int middle = 2 * step_ + 1, end = 2 * step_ + 2, end_point = end == 2 * tables_.steps ? 0 : end;
    heat_rates(middle, heat_[1]);
    heat_rates(end, heat_[2]);
    State at, k2, k3, k4;
    Totals unused;
    add<W>(state_, h / 2, slope_, at);
    if (stands_still(at)) return false;
    evaluate<W>(middle, at, heat_[1], k2, unused);
    add<W>(state_, h / 2, k2, at);
    if (stands_still(at)) return false;
    evaluate<W>(middle, at, heat_[1], k3, unused);
    add<W>(state_, h, k3, at);
    if (stands_still(at)) return false;
    evaluate<W>(end_point, at, heat_[2], k4, unused);
    commit<W>(k2, k3, k4);
    std::copy(heat_[2], heat_[2] + W, heat_[0]);
    if (++step_ == tables_.steps) step_ = 0, next_event_ = 0, ++cycle_;
    take_events();
    evaluate<W>(2 * step_, state_, heat_[0], slope_, totals_);
    update_truth();
    return true;
}

bool EngineModel::step() {
    switch (tables_.width) {
    case 2:
        return step_width<2>();
    case 4:
        return step_width<4>();
    case 6:
        return step_width<6>();
    default:
        return step_width<8>();
    }
}

void EngineModel::evaluate_here() {
    if (prescribed_) { // keeps the energy at hand for the moment the crank is released
        const double speed = speed_at(2 * step_, state_);
        state_.energy = 0.5 * tables_.inertia[std::size_t(2 * step_)] * speed * speed;
    }
    switch (tables_.width) {
    case 2:
        evaluate<2>(2 * step_, state_, heat_[0], slope_, totals_);
        break;
    case 4:
        evaluate<4>(2 * step_, state_, heat_[0], slope_, totals_);
        break;
    case 6:
        evaluate<6>(2 * step_, state_, heat_[0], slope_, totals_);
        break;
    default:
        evaluate<8>(2 * step_, state_, heat_[0], slope_, totals_);
        break;
    }
    update_truth();
}

void EngineModel::take_events() {
    first_event_ = next_event_;
    while (next_event_ < tables_.events.size() && tables_.events[next_event_].step == step_) {
        apply(tables_.events[next_event_++]);
    }
}

void EngineModel::apply(const Event &event) {
    const int lane = event.lane, twin = lane + kTwins;
    const auto l = std::size_t(lane);
    switch (event.kind) {
    case EventKind::intake_close:
        inhaling_[l] = false;
        state_.p[twin] = state_.p[lane];
        mass_[l] = state_.p[lane] * volume(lane) / (gas::kR * charge_k_);
        for (int i : {lane, twin}) {
            closed_[i] = 1, open_[i] = 0;
            inverse_mr_[i] = 1 / (mass_[l] * gas::kR);
            wall_gain_[i] = std::sqrt(inverse_mr_[i]);
        }
        peak_[lane] = 0;
        set_charge(lane, Charge{});
        break;
    case EventKind::tdc:
        running_[l].cycle = cycle_;
        running_[l].tdc_time_s = state_.time;
        running_[l].tdc_speed_radps = speed_at(2 * step_, state_);
        work_at_tdc_[l] = state_.work[lane] - state_.work[twin];
        break;
    case EventKind::half_turn:
        running_[l].combustion_torque_nm = (state_.work[lane] - state_.work[twin] - work_at_tdc_[l]) / kPi;
        break;
    case EventKind::exhaust_open:
        for (int i : {lane, twin})
            closed_[i] = 0, open_[i] = exchange_, manifold_[i] = exhaust_pa_, wall_gain_[i] = 0;
        heat_[0][lane] = 0;
        burns_[l] = false;
        break;
    case EventKind::exchange:
        inhaling_[l] = true;
        for (int i : {lane, twin}) manifold_[i] = intake_pa_[l];
        finish_cycle(lane);
        break;
    }
}

void EngineModel::finish_cycle(int lane) {
    const auto l = std::size_t(lane);
    CycleTruth &cycle = running_[l];
    cycle.cylinder = physical_[l];
    cycle.work_j = state_.work[lane];
    cycle.imep_pa = cycle.work_j / displacement_m3_;
    cycle.combustion_work_j = state_.work[lane] - state_.work[lane + kTwins];
    cycle.wall_loss_j = state_.wall[lane];
    cycle.heat_j = released_[l];
    cycle.peak_pressure_pa = peak_[lane];
    finished_[l] = cycle;
    cycle = CycleTruth{};
    for (int i : {lane, lane + kTwins}) state_.work[i] = state_.wall[i] = 0;
}

void EngineModel::update_truth() {
    double motored = 0, fired = 0;
    for (int i = 0; i < n_; ++i) fired += slope_.work[i], motored += slope_.work[i + kTwins];
    truth_.angle_rad = (double(cycle_) * tables_.steps + step_) * tables_.step_rad;
    truth_.time_s = state_.time;
    truth_.speed_radps = totals_.speed;
    truth_.combustion_torque_nm = fired - motored;
    truth_.gas_torque_nm = totals_.gas;
    truth_.load_torque_nm = totals_.load;
    truth_.net_torque_nm = totals_.gas - totals_.load;
}

} // namespace sixdeg
