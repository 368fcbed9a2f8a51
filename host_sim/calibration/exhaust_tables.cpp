// SPDX-License-Identifier: MIT
#include "calibration/exhaust_tables.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

constexpr double kR = 287, kGamma = 1.34, kAmbientPa = 101300;
constexpr double kChargeK = 335, kStoichiometric = 14.6, kHeatJpkg = 42.7e6,
                 kHeatKept = 0.75;              // typical of a diesel
constexpr double kCoolingWpk = 4, kWallK = 500; // of the manifold
constexpr double kStepDeg = 0.25, kRadPerDeg = M_PI / 180;
constexpr int kCycles = 4; // until the manifold repeats itself

double psi(double z) { // over z = upstream/downstream pressure
    const double choke = std::pow((kGamma + 1) / 2, kGamma / (kGamma - 1)), r = 1 / std::clamp(z, 1.0, choke);
    return std::sqrt(2 * kGamma / (kGamma - 1) *
                     (std::pow(r, 2 / kGamma) - std::pow(r, (kGamma + 1) / kGamma)));
}

struct Piston {
    explicit Piston(const EngineFile &e)
        : area(M_PI / 4 * e.bore_m * e.bore_m), crank(e.stroke_m / 2), rod(e.rod_m),
          clearance(area * e.stroke_m / (e.compression_ratio - 1)) {}
    double volume(double theta) const {
        const double s = crank * std::sin(theta);
        return clearance + area * (crank * (1 - std::cos(theta)) + rod - std::sqrt(rod * rod - s * s));
    }
    double area, crank, rod, clearance;
};

/// Pressure when the exhaust valve opens: polytropic compression, heat at once, polytropic expansion.
double opening_pressure(const Piston &piston, const EngineFile &engine, double fuel_kg, double intake_pa) {
    constexpr double kCompress = 1.35, kExpand = 1.30, kBurnRad = 0.3;
    const double v0 = piston.volume(kRadPerDeg * engine.intake_close_deg), v1 = piston.volume(kBurnRad),
                 v2 = piston.volume(kRadPerDeg * engine.exhaust_open_deg);
    const double cv = kR / (kExpand - 1);
    const double burned =
        intake_pa * std::pow(v0 / v1, kCompress) + kHeatKept * fuel_kg * kHeatJpkg / cv * kR / v1;
    return burned * std::pow(v1 / v2, kExpand);
}

struct Gas { // of an open cylinder; entropy stays, so pressure follows mass and volume
    double kg, pa, m3;
    double kelvin() const { return pa * m3 / (kg * kR); }
    void change(double new_kg, double new_m3) {
        pa *= std::pow(new_kg / kg * m3 / new_m3, kGamma);
        kg = new_kg, m3 = new_m3;
    }
};

class Blowdown {
  public:
    Blowdown(const EngineFile &engine, double speed, double intake_pa, double lambda)
        : engine_(engine), exhaust_(*engine.exhaust), open_rad_(kRadPerDeg * engine.exhaust_open_deg),
          piston_(engine), speed_(speed),
          trapped_(exhaust_.flow_factor * intake_pa * piston_.volume(kRadPerDeg * engine.intake_close_deg) /
                   (kR * kChargeK)),
          fuel_(trapped_ * lambda / (1 + kStoichiometric - lambda)),
          opening_pa_(opening_pressure(piston_, engine, fuel_, intake_pa)), manifold_k_(700),
          share_(std::size_t(2 * engine.wheel.positions), 0.0),
          gas_(engine.firing_tdc_deg.size(), Gas{trapped_, kAmbientPa, piston_.volume(M_PI)}) {}

    ExhaustPoint run() {
        const int steps = int(std::lround(720 / kStepDeg));
        kg_ = 1.2 * kAmbientPa * exhaust_.manifold_m3 / (kR * manifold_k_);
        for (int i = 0; i < kCycles * steps; ++i) {
            step(i % steps, i >= (kCycles - 1) * steps);
            if (i % steps == steps - 1 && i < (kCycles - 1) * steps) new_temperature();
        }
        double passed = 0;
        for (double &s : share_) passed += s = std::max(s, 0.0); // what flows back is left out
        for (double &s : share_) s /= passed;
        const double charge = trapped_ + fuel_, flow = charge * double(gas_.size()) * speed_ / (4 * M_PI);
        const double transport = (exhaust_.pipe_m3 + exhaust_.mixing_m3) * kAmbientPa / (kR * manifold_k_);
        const double area = exhaust_.turbine_area_m2.at(speed_);
        return {share_,
                charge,
                area * std::sqrt(kR * manifold_k_) / exhaust_.manifold_m3,
                kAmbientPa * exhaust_.manifold_m3 / (kR * manifold_k_),
                sum_kg_ / steps,
                transport,
                transport / flow + exhaust_.dead_time_s,
                trapped_};
    }

  private:
    /// Positions are counted from the first at or after TDC, and hold what passes in the pitch that ends
    /// there.
    std::size_t share_index(double theta) const {
        const double after_tdc =
            (engine_.firing_tdc_deg[0] - engine_.position_0_deg) / 360 * engine_.wheel.positions;
        const double late = std::ceil(after_tdc - 1e-9) - after_tdc;
        const long k = std::lround(std::ceil(theta / (2 * M_PI) * engine_.wheel.positions - late - 1e-9));
        return std::size_t(std::max(k, 0L));
    }

    double valve_area(double theta) const {
        const double x = (theta - open_rad_) / (exhaust_.valve_close_rad - open_rad_);
        return x <= 0 || x >= 1 ? 0 : exhaust_.valve_area_m2 * std::pow(std::sin(M_PI * x), 2);
    }

    void step(int index, bool measured) {
        const double h = kStepDeg * kRadPerDeg, dt = h / speed_, inflow = pass_valves(index, h, dt, measured);
        const double z = pressure() / kAmbientPa;
        const double out =
            exhaust_.turbine_area_m2.at(speed_) * pressure() / std::sqrt(kR * manifold_k_) * psi(z) * dt;
        kg_ += inflow - out;
        if (measured) sum_kg_ += kg_;
    }

    double pressure() const { return kg_ * kR * manifold_k_ / exhaust_.manifold_m3; }

    double pass_valves(int index, double h, double dt, bool measured) {
        double inflow = 0;
        for (std::size_t i = 0; i < gas_.size(); ++i) {
            double theta = index * h - engine_.firing_tdc_deg[i] * kRadPerDeg;
            if (theta < 0) theta += 4 * M_PI;
            const double area = valve_area(theta), volume = piston_.volume(theta);
            if (area <= 0) {
                gas_[i] = {trapped_ + fuel_, opening_pa_, volume};
                continue;
            }
            gas_[i].change(gas_[i].kg, volume);
            const double passed = through_valve(gas_[i], area, dt);
            gas_[i].change(gas_[i].kg - passed, volume);
            inflow += passed;
            heat_ += passed * gas_[i].kelvin(), flowed_ += passed;
            if (measured && i == 0) share_[share_index(theta)] += passed;
        }
        return inflow;
    }

    /// No more than evens the pressures out, so that long steps cannot overshoot.
    double through_valve(const Gas &gas, double area, double dt) const {
        const bool forward = gas.pa >= pressure();
        const double up = std::max(gas.pa, pressure()), down = std::min(gas.pa, pressure());
        const double t = forward ? gas.kelvin() : manifold_k_;
        const double even = gas.kg * (1 - std::pow(down / up, 1 / kGamma)) / 2;
        return std::min(area * up / std::sqrt(kR * t) * psi(up / down) * dt, even) * (forward ? 1 : -1);
    }

    void new_temperature() {
        const double cp = kGamma * kR / (kGamma - 1), per_cycle_s = 4 * M_PI / speed_;
        const double kg = flowed_, in = heat_ / flowed_, loss = kCoolingWpk * per_cycle_s / (kg * cp);
        const double before = manifold_k_;
        manifold_k_ = (in + loss * kWallK) / (1 + loss);
        kg_ *= before / manifold_k_;
        heat_ = flowed_ = 0;
    }

    const EngineFile &engine_;
    const ExhaustSystem &exhaust_;
    double open_rad_;
    Piston piston_;
    double speed_, trapped_, fuel_, opening_pa_, manifold_k_;
    std::vector<double> share_;
    std::vector<Gas> gas_;
    double kg_ = 0, sum_kg_ = 0, heat_ = 0, flowed_ = 0;
};

} // namespace

ExhaustPoint exhaust_point(const EngineFile &engine, double speed_radps, double intake_pa, double lambda) {
    return Blowdown(engine, speed_radps, intake_pa, lambda).run();
}

namespace {

constexpr double kRpm[SD_AFR_SPEEDS] = {800, 1700, 3000, 4800}, kBar[SD_AFR_PRESSURES] = {0.9, 1.5, 2.5},
                 kLambda[SD_AFR_LAMBDAS] = {0.25, 0.75};
constexpr double kMassCharges = 12; // the manifold never holds the gas of so many cylinders

sd_afr_node_t page_node(const ExhaustPoint &point, int open_position) {
    sd_afr_node_t node{};
    const auto cycle = point.share.size();
    for (std::size_t k = 0; k < std::min<std::size_t>(SD_AFR_OPEN, cycle); ++k)
        node.share[k] =
            std::uint16_t(std::lround(65535 * point.share[(std::size_t(open_position) + k) % cycle]));
    node.rate_hz = float(point.rate_hz);
    node.z0_kg = float(point.z0_kg);
    node.transport_kg = float(point.transport_kg);
    return node;
}

} // namespace

sd_afr_grid_t afr_grid(const EngineFile &engine) {
    sd_afr_grid_t grid{};
    if (!engine.exhaust) return grid;
    grid.present = 1;
    const int open = int(std::floor(engine.exhaust_open_deg / 360 * engine.wheel.positions));
    grid.open_position = std::uint16_t(open);
    ExhaustPoint point;
    for (int s = 0; s < SD_AFR_SPEEDS; ++s) {
        for (int p = 0; p < SD_AFR_PRESSURES; ++p) {
            for (int l = 0; l < SD_AFR_LAMBDAS; ++l) {
                point = exhaust_point(engine, kRpm[s] * M_PI / 30, kBar[p] * 1e5, kLambda[l]);
                grid.node[s][p][l] = page_node(point, open);
            }
        }
    }
    for (int s = 0; s < SD_AFR_SPEEDS; ++s) grid.speed_radps[s] = float(kRpm[s] * M_PI / 30);
    std::copy(std::begin(kBar), std::end(kBar), grid.pressure_bar);
    std::copy(std::begin(kLambda), std::end(kLambda), grid.lambda);
    grid.air_kg_per_bar = float(point.air_kg / kBar[SD_AFR_PRESSURES - 1]);
    grid.mass_base_kg = float(kMassCharges * point.charge_kg);
    grid.dead_s = float(engine.exhaust->dead_time_s);
    grid.tau1_s = float(engine.exhaust->uego_tau_s[0]);
    grid.tau2_s = float(engine.exhaust->uego_tau_s[1]);
    const auto psi = exhaust_psi();
    std::copy(psi.begin(), psi.end(), grid.psi);
    return grid;
}

std::array<double, 33> exhaust_psi() {
    std::array<double, 33> table{};
    for (std::size_t k = 0; k < table.size(); ++k) table[k] = psi(1 + double(k) / 32);
    return table;
}

} // namespace sixdeg
