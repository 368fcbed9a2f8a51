// SPDX-License-Identifier: MIT
#include "plant/airpath/full_model.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg::airpath {
namespace {

constexpr double kAirR = 287, kAirGamma = 1.4, kAirCp = kAirGamma * kAirR / (kAirGamma - 1), kAirCv = kAirCp - kAirR;
constexpr double kGasR = 286, kGasGamma = 1.33, kGasCp = kGasGamma * kGasR / (kGasGamma - 1), kGasCv = kGasCp - kGasR;
constexpr double kHeatingValue = 42.7e6;
constexpr double kRatedKgps = 0.1; // at which pressure losses are given
constexpr double kTurboFrictionW = 200; // at rated speed, with its square

double square(double x) { return x * x; }

/// Mass flow over area, pressure and 1/sqrt(R T): isentropic, choked below the critical ratio, a straight line above 0.97 where the
/// root has no slope.
struct Nozzle {
    explicit Nozzle(double gamma)
        : inverse(1 / gamma), factor(2 * gamma / (gamma - 1)), critical(std::pow(2 / (gamma + 1), gamma / (gamma - 1))),
            at_straight(isentropic(0.97)) {}
    double isentropic(double ratio) const {
        const double root = std::pow(ratio, inverse);
        return std::sqrt(factor * root * (root - ratio));
    }
    double operator()(double ratio) const {
        if (ratio >= 1) return 0;
        if (ratio > 0.97) return at_straight * (1 - ratio) / 0.03;
        return isentropic(std::max(ratio, critical));
    }
    double inverse, factor, critical, at_straight;
};
const Nozzle kAirNozzle(kAirGamma), kGasNozzle(kGasGamma);

/// The same of a valve before which the pressure swings by `swing` of its mean six times a cycle: the mean flow is straight in the
/// mean drop as long as the drop is smaller than the swing, and grows with its root beyond. A flap behind the valve lets nothing back.
double pulsating(double drop, double swing) {
    if (drop <= 0) return 0;
    return std::sqrt(2.0) * drop / std::sqrt(std::sqrt(square(drop) + square(swing))) * (1 - drop / 2);
}

/// Flow through a resistance that loses drop_pa at kRatedKgps, with the square of the flow; straight near none.
double through(double up_pa, double down_pa, double drop_pa) {
    constexpr double kStraightPa = 300;
    const double difference = up_pa - down_pa, size = std::abs(difference);
    const double flow = kRatedKgps * std::sqrt(std::max(size, kStraightPa) / drop_pa) * std::min(size / kStraightPa, 1.0);
    return difference < 0 ? -flow : flow;
}

double cooled(double in_k, double coolant_k, double effectiveness, double kgps) {
    return coolant_k + (1 - effectiveness / (1 + 0.8 * std::max(kgps, 0.0))) * (in_k - coolant_k);
}

/// Vanes pass more at the beginning of their way than at its end.
double vane_area_m2(const FullData &d, double position) {
    const double x = std::clamp(position, 0.0, 1.0);
    return d.turbine_closed_m2 + d.turbine_span_m2 * x * (1.15 - 0.15 * x);
}

/// A poppet valve that opens a little late.
double valve_area_m2(const FullData &d, double opening) {
    const double x = std::clamp(opening, 0.0, 1.0);
    return d.egr_area_m2 * x * (0.85 + 0.3 * x - 0.15 * x * x);
}

void add(State &to, double h, const State &rate) {
    to.boost_kg += h * rate.boost_kg, to.boost_j += h * rate.boost_j;
    to.air_kg += h * rate.air_kg, to.egr_kg += h * rate.egr_kg, to.intake_j += h * rate.intake_j;
    to.exhaust_kg += h * rate.exhaust_kg, to.exhaust_j += h * rate.exhaust_j, to.wall_k += h * rate.wall_k;
    to.leaving_kgps += h * rate.leaving_kgps, to.leaving_k += h * rate.leaving_k;
    to.egr_k += h * rate.egr_k;
    to.turbo_radps += h * rate.turbo_radps;
}

} // namespace

FullModel::FullModel(const FullData &data, double displacement_m3, double compression_ratio)
    : data_(data), displacement_m3_(displacement_m3), compression_ratio_(compression_ratio) {}

Flows FullModel::flows_at(const State &s, const Drive &drive) const {
    const FullData &d = data_;
    Flows f;
    f.leaving_kgps = s.leaving_kgps;
    f.boost_pa = (kAirGamma - 1) * s.boost_j / d.cooler_m3;
    f.charge_k = s.boost_j / (s.boost_kg * kAirCv);
    f.intake_pa = (kAirGamma - 1) * s.intake_j / d.intake_m3;
    f.intake_k = s.intake_j / ((s.air_kg + s.egr_kg) * kAirCv);
    f.exhaust_pa = (kGasGamma - 1) * s.exhaust_j / d.exhaust_m3;
    f.exhaust_k = s.exhaust_j / (s.exhaust_kg * kGasCv);

    const double tip_mps = s.turbo_radps * d.compressor_m / 2;
    f.isentropic_rise_k = d.ambient_k * (std::pow(f.boost_pa / d.ambient_pa, 1 - 1 / kAirGamma) - 1);
    const double share = std::clamp(2 * kAirCp * f.isentropic_rise_k / (tip_mps * tip_mps) / d.compressor_head, 0.0, 1.0);
    f.compressor_kgps = d.compressor_flow * (1 - square(square(share))) * M_PI / 4 * d.compressor_m * d.compressor_m * tip_mps *
                        d.ambient_pa / (kAirR * d.ambient_k);
    f.charge_kgps = through(f.boost_pa, f.intake_pa, d.cooler_drop_pa);
    f.egr_kgps = valve_area_m2(d, drive.egr) * f.exhaust_pa / std::sqrt(kGasR * f.exhaust_k) * pulsating(1 - f.intake_pa / f.exhaust_pa,
        d.egr_pulsation);
    if (drive.leak_m2 > 0)
        f.leak_kgps = drive.leak_m2 * f.intake_pa / std::sqrt(kAirR * f.intake_k) * kAirNozzle(d.ambient_pa / f.intake_pa);

    const double rpm = drive.speed_radps * 30 / M_PI, off = (rpm - d.filling_rpm) / 1000;
    const double rest = (compression_ratio_ - std::pow(f.exhaust_pa / f.intake_pa, 1 / kGasGamma)) / (compression_ratio_ - 1);
    const double filling = (d.filling - d.filling_bend * off * off) * rest * std::sqrt(std::sqrt(f.intake_k / 320));
    f.cylinder_kgps = filling * displacement_m3_ * drive.speed_radps / (4 * M_PI) * f.intake_pa / (kAirR * f.intake_k);

    // Stator and rotor as two equal nozzles behind one another; what is behind the turbine follows the flow of the cylinders.
    f.behind_pa = d.ambient_pa + d.back_pressure_pa * square(s.leaving_kgps / kRatedKgps);
    const double turned = s.turbo_radps / d.turbo_rated_radps;
    const double area = vane_area_m2(d, drive.vgt) * (1 - d.turbine_swallow_drop * turned * turned);
    f.turbine_kgps = area * f.exhaust_pa / std::sqrt(kGasR * f.exhaust_k) * kGasNozzle(std::sqrt(std::min(f.behind_pa / f.exhaust_pa,
        1.0)));
    return f;
}

void FullModel::turbine_and_compressor(const State &s, const Flows &f, double &turbine_w, double &compressor_w, double &out_k) const {
    const FullData &d = data_;
    const double drop_jpkg = kGasCp * f.exhaust_k * (1 - std::pow(std::min(f.behind_pa / f.exhaust_pa, 1.0), 1 - 1 / kGasGamma));
    const double tip_mps = s.turbo_radps * d.compressor_m / 2; // both wheels are as large
    const double blade = tip_mps / std::sqrt(2 * std::max(drop_jpkg, 500.0)), off = blade / 0.68 - 1;
    const double efficiency = d.turbine_efficiency * std::max(1 - off * off, 0.2);
    turbine_w = efficiency * f.turbine_kgps * drop_jpkg;

    const double full_kgps = d.compressor_flow * M_PI / 4 * d.compressor_m * d.compressor_m * tip_mps * d.ambient_pa / (kAirR *
        d.ambient_k);
    const double load = f.compressor_kgps / full_kgps - 0.65;
    const double of_compressor = d.compressor_efficiency * std::max(1 - 1.2 * load * load, 0.3);
    const double rise_k = f.isentropic_rise_k / of_compressor;
    out_k = d.ambient_k + rise_k;
    compressor_w = f.compressor_kgps * kAirCp * rise_k;
}

State FullModel::rates(const State &s, const Drive &drive) const {
    const FullData &d = data_;
    const Flows f = flows_at(s, drive);
    State r;
    double turbine_w, compressor_w, compressor_k;
    turbine_and_compressor(s, f, turbine_w, compressor_w, compressor_k);

    const double charge_k = f.charge_kgps >= 0 ? f.charge_k : f.intake_k;
    r.boost_kg = f.compressor_kgps - f.charge_kgps;
    r.boost_j = kAirCp * (f.compressor_kgps * cooled(compressor_k, d.cooler_k, d.cooler_effectiveness, f.compressor_kgps) -
                          f.charge_kgps * charge_k);

    const double out = f.cylinder_kgps + f.leak_kgps, air_share = s.air_kg / (s.air_kg + s.egr_kg);
    r.air_kg = f.charge_kgps - out * air_share;
    r.egr_kg = f.egr_kgps - out * (1 - air_share);
    r.intake_j = kAirCp * (f.charge_kgps * charge_k + f.egr_kgps * s.egr_k - out * f.intake_k);

    // The cylinders' gas reaches the manifold three strokes after it was drawn in.
    const double late_s = 1.5 * 2 * M_PI / drive.speed_radps;
    const double heated_k = f.intake_k + d.heat_share * kHeatingValue * drive.fuel_kgps / (kGasCp * (f.cylinder_kgps + drive.fuel_kgps));
    r.leaving_kgps = (f.cylinder_kgps + drive.fuel_kgps - s.leaving_kgps) / late_s;
    r.leaving_k = (heated_k - s.leaving_k) / late_s;
    const double to_wall_w = d.wall_wpk * (f.exhaust_k - s.wall_k);
    r.exhaust_kg = s.leaving_kgps - f.egr_kgps - f.turbine_kgps;
    r.exhaust_j = kGasCp * (s.leaving_kgps * s.leaving_k - (f.egr_kgps + f.turbine_kgps) * f.exhaust_k) - to_wall_w;
    r.wall_k = (to_wall_w - d.wall_loss_wpk * (s.wall_k - d.ambient_k)) / d.wall_jpk;

    r.egr_k = (cooled(f.exhaust_k, d.egr_cooler_k, d.egr_cooler_effectiveness, 4 * f.egr_kgps) - s.egr_k) / d.egr_cooler_s;
    const double turned = s.turbo_radps / d.turbo_rated_radps;
    r.turbo_radps = (turbine_w - compressor_w - kTurboFrictionW * turned * turned) / (d.turbo_inertia_kgm2 * s.turbo_radps);
    return r;
}

// The midpoint rule; the fastest of the states moves in 3 ms.
void FullModel::step(const Drive &drive, double dt_s) {
    State middle = state_;
    add(middle, dt_s / 2, rates(state_, drive));
    add(state_, dt_s, rates(middle, drive));
    state_.turbo_radps = std::max(state_.turbo_radps, 0.02 * data_.turbo_rated_radps);
    flows_ = flows_at(state_, drive);
}

void FullModel::start(const Drive &drive) {
    constexpr double kStartPa = 1.3e5, kStartExhaustPa = 1.5e5, kStartK = 320, kStartExhaustK = 700, kSettleS = 15;
    const FullData &d = data_;
    state_.boost_j = kStartPa * d.cooler_m3 / (kAirGamma - 1), state_.boost_kg = state_.boost_j / (kAirCv * kStartK);
    state_.intake_j = kStartPa * d.intake_m3 / (kAirGamma - 1), state_.air_kg = state_.intake_j / (kAirCv * kStartK);
    state_.egr_kg = 0.1 * state_.air_kg, state_.air_kg *= 0.9;
    state_.exhaust_j = kStartExhaustPa * d.exhaust_m3 / (kGasGamma - 1);
    state_.exhaust_kg = state_.exhaust_j / (kGasCv * kStartExhaustK);
    state_.leaving_kgps = 0.1, state_.leaving_k = kStartExhaustK, state_.egr_k = d.egr_cooler_k;
    state_.turbo_radps = 0.6 * d.turbo_rated_radps;
    state_.wall_k = kStartExhaustK - 50;
    const double stored = data_.wall_jpk;
    data_.wall_jpk = std::min(stored, 20.0); // so that the wall has settled too
    for (double t = 0; t < kSettleS; t += 1e-3) step(drive, 1e-3);
    data_.wall_jpk = stored;
}

} // namespace sixdeg::airpath
