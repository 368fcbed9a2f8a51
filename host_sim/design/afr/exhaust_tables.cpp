// SPDX-License-Identifier: MIT
#include "design/afr/exhaust_tables.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "design/torque/pulse.hpp"
#include "design/crank/slider_crank.hpp"
#include "design/afr/uego_gains.hpp"
#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

constexpr double kR = 287, kGamma = 1.34, kAmbientPa = 101300;
constexpr double kCp = kGamma * kR / (kGamma - 1), kCv = kCp - kR;
constexpr double kChargeK = 335, kStoichiometric = 14.6;
constexpr double kCoolingWpk = 4, kWallK = 500; // of the manifold
constexpr double kStepDeg = 0.25, kRadPerDeg = M_PI / 180;
constexpr int kCycles = 6, kFirings = 3; // until the manifold repeats itself, and the cylinder's rest

/// Of a pressure ratio down/up and its power 1/gamma.
double psi(double ratio, double root) {
    static const double choked = std::pow(2 / (kGamma + 1), kGamma / (kGamma - 1)), choked_root = std::pow(choked, 1 / kGamma);
    if (ratio <= choked) ratio = choked, root = choked_root;
    return std::sqrt(2 * kGamma / (kGamma - 1) * (root * root - root * ratio));
}

double psi(double z) { // over z = upstream/downstream pressure
    const double ratio = std::min(1 / z, 1.0);
    return psi(ratio, std::pow(ratio, 1 / kGamma));
}

/// (1 + x)^gamma: the binomial series while x is small, 1e-14 off.
double isentropic(double x) {
    if (std::abs(x) > 0.01) return std::pow(1 + x, kGamma);
    constexpr double c1 = kGamma, c2 = c1 * (kGamma - 1) / 2, c3 = c2 * (kGamma - 2) / 3, c4 = c3 * (kGamma - 3) / 4,
                     c5 = c4 * (kGamma - 4) / 5, c6 = c5 * (kGamma - 5) / 6;
    return 1 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * (c5 + x * c6)))));
}

struct Gas { // of an open cylinder; entropy stays, so pressure follows mass and volume
    double kg, pa, m3;
    double kelvin() const { return pa * m3 / (kg * kR); }
    void change(double new_kg, double new_m3) {
        pa *= isentropic(new_kg / kg * m3 / new_m3 - 1);
        kg = new_kg, m3 = new_m3;
    }
};

/// Factors on what the model knows least: charge, turbine area, pressure when the exhaust valve opens.
struct Trim {
    double charge = 1, area = 1, heat = 1;
};

} // namespace

/// What depends on the crank's angle only, and is the same at every operating point.
struct TrimmedExhaust::Turn {
    struct Passage { ///< Of a cylinder over one step.
        double theta, area, volume; ///< rad from firing TDC; m2 of its exhaust valve; m3.
    };

    explicit Turn(const EngineFile &engine) : piston(engine), opening_pa(exhaust_opening(engine)), passages(engine.firing_tdc_deg.size()) {
        const double open_rad = kRadPerDeg * engine.exhaust_open_deg, close_rad = engine.exhaust->valve_close_rad;
        for (std::size_t i = 0; i < passages.size(); ++i) {
            for (int step = 0; step < steps; ++step) {
                double theta = step * step_rad - engine.firing_tdc_deg[i] * kRadPerDeg;
                if (theta < 0) theta += 4 * M_PI;
                const double x = (theta - open_rad) / (close_rad - open_rad);
                const double area = x <= 0 || x >= 1 ? 0 : engine.exhaust->valve_area_m2 * std::pow(std::sin(M_PI * x), 2);
                passages[i].push_back({theta, area, piston.volume(theta)});
            }
        }
    }

    const double step_rad = kStepDeg * kRadPerDeg;
    const int steps = int(std::lround(720 / kStepDeg));
    const SliderCrank piston;
    const std::function<double(const PulseConditions &)> opening_pa;
    std::vector<std::vector<Passage>> passages; ///< [cylinder][step]
};

namespace {

class Blowdown {
  public:
    Blowdown(const EngineFile &engine, const TrimmedExhaust::Turn &turn, double speed, double intake_pa, double lambda, const Trim &trim)
        : engine_(engine), exhaust_(*engine.exhaust), turn_(turn), speed_(speed),
          area_(trim.area * exhaust_.turbine_area_m2.at(speed)), heat_(trim.heat),
          trapped_(trim.charge * exhaust_.flow_factor * intake_pa * turn.piston.volume(kRadPerDeg * engine.intake_close_deg) /
                   (kR * kChargeK)),
          lambda_(lambda), intake_pa_(intake_pa), rest_(0.05 * trapped_),
          share_(std::size_t(2 * engine.wheel.positions), 0.0),
          gas_(engine.firing_tdc_deg.size(), Gas{trapped_, kAmbientPa, turn.piston.volume(M_PI)}) {}

    ExhaustPoint run() {
        constexpr double kStartK = 700;
        kg_ = 1.2 * kAmbientPa * exhaust_.manifold_m3 / (kR * kStartK);
        joule_ = kg_ * kCv * kStartK;
        const int steps = turn_.steps;
        for (int cycle = 0; cycle < kCycles; ++cycle) {
            if (cycle < kFirings) fire();
            for (int i = 0; i < steps; ++i) step(i, cycle == kCycles - 1);
        }
        for (double &s : share_) s = std::max(s, 0.0) / (trapped_ + fuel_); // what flows back is left out
        const double kelvin = sum_k_ / steps, ambient_kg_per_m3 = kAmbientPa / (kR * kelvin);
        return {share_,
                trapped_ + fuel_,
                area_ * std::sqrt(kR * kelvin) / exhaust_.manifold_m3,
                ambient_kg_per_m3 * exhaust_.manifold_m3,
                sum_kg_ / steps,
                ambient_kg_per_m3 * (exhaust_.pipe_m3 + exhaust_.mixing_m3),
                trapped_,
                {speed_, intake_pa_, lambda_, trapped_ - rest_, sum_pa_ / steps, kelvin}};
    }

  private:
    /// What stays in a cylinder is burned already: only the rest of the charge is air for fuel.
    void fire() {
        fuel_ = (trapped_ - rest_) * lambda_ / (1 + kStoichiometric - lambda_);
        opening_pa_ =
            heat_ * turn_.opening_pa({intake_pa_ / 1e5, speed_, kStoichiometric * fuel_ / trapped_});
    }

    /// Positions are counted from the first at or after TDC, and hold what passes in the pitch that ends
    /// there.
    std::size_t share_index(double theta) const {
        const double after_tdc =
            (engine_.firing_tdc_deg[0] - engine_.position_0_deg) / 360 * engine_.wheel.positions;
        const double late = std::ceil(after_tdc - 1e-9) - after_tdc;
        const long k = std::lround(std::ceil(theta / (2 * M_PI) * engine_.wheel.positions - late - 1e-9));
        return std::size_t(std::max(k, 0L));
    }

    void step(int index, bool measured) {
        const double dt = turn_.step_rad / speed_, kelvin = manifold_k();
        const double out = area_ * pressure() / std::sqrt(kR * kelvin) *
                           psi(pressure() / kAmbientPa) * dt;
        pass_valves(index, dt, measured);
        kg_ -= out;
        joule_ -= out * kCp * kelvin + kCoolingWpk * (kelvin - kWallK) * dt;
        if (measured) sum_kg_ += kg_, sum_k_ += manifold_k(), sum_pa_ += pressure();
    }

    double manifold_k() const { return joule_ / (kg_ * kCv); }
    double pressure() const { return kR / kCv * joule_ / exhaust_.manifold_m3; }

    void pass_valves(int index, double dt, bool measured) {
        for (std::size_t i = 0; i < gas_.size(); ++i) {
            const auto [theta, area, volume] = turn_.passages[i][std::size_t(index)];
            if (area <= 0) {
                gas_[i] = {trapped_ + fuel_, opening_pa_, volume};
                continue;
            }
            gas_[i].change(gas_[i].kg, volume);
            const double passed = through_valve(gas_[i], area, dt);
            gas_[i].change(gas_[i].kg - passed, volume);
            kg_ += passed;
            joule_ += passed * kCp * (passed > 0 ? gas_[i].kelvin() : manifold_k());
            if (i == 0) rest_ = gas_[i].kg; // the last one stands
            if (measured && i == 0) share_[share_index(theta)] += passed;
        }
    }

    /// No more than evens the pressures out, so that long steps cannot overshoot.
    double through_valve(const Gas &gas, double area, double dt) const {
        const bool forward = gas.pa >= pressure();
        const double up = std::max(gas.pa, pressure()), down = std::min(gas.pa, pressure());
        const double t = forward ? gas.kelvin() : manifold_k();
        const double ratio = down / up, root = std::pow(ratio, 1 / kGamma), even = gas.kg * (1 - root) / 2;
        return std::min(area * up / std::sqrt(kR * t) * psi(ratio, root) * dt, even) * (forward ? 1 : -1);
    }

    const EngineFile &engine_;
    const ExhaustSystem &exhaust_;
    const TrimmedExhaust::Turn &turn_;
    double speed_, area_, heat_, trapped_, lambda_, intake_pa_, rest_, fuel_ = 0, opening_pa_ = 0;
    std::vector<double> share_;
    std::vector<Gas> gas_;
    double kg_ = 0, joule_ = 0, sum_kg_ = 0, sum_k_ = 0, sum_pa_ = 0; // of the manifold
};

/// Trim at one reading: the model is run until it reads the same.
Trim trim_at(const EngineFile &engine, const TrimmedExhaust::Turn &turn, const ExhaustReading &r) {
    Trim trim;
    for (int i = 0; i < 3; ++i) {
        const ExhaustReading model = Blowdown(engine, turn, r.speed_radps, r.intake_pa, r.lambda, trim).run().reading;
        trim.charge *= r.air_kg * engine.exhaust->flow_factor / model.air_kg;
        trim.heat *= r.kelvin / model.kelvin;
        trim.area *= model.pressure_pa / r.pressure_pa;
    }
    return trim;
}

} // namespace

// Each factor is the exponential of a plane over speed, intake pressure and lambda, laid through the readings.
TrimmedExhaust::TrimmedExhaust(const EngineFile &engine) : engine_(engine), turn_(std::make_shared<Turn>(engine)) {
    const auto &readings = engine.exhaust->readings;
    if (readings.empty()) return;
    Eigen::MatrixXd at(readings.size(), 4), log_trim(readings.size(), 3);
    for (Eigen::Index i = 0; i < at.rows(); ++i) {
        const ExhaustReading &r = readings[std::size_t(i)];
        const Trim trim = trim_at(engine, *turn_, r);
        at.row(i) << 1, r.speed_radps, r.intake_pa, r.lambda;
        log_trim.row(i) << std::log(trim.charge), std::log(trim.area), std::log(trim.heat);
    }
    plane_ = linalg::least_squares(at, log_trim);
}

ExhaustPoint TrimmedExhaust::point(double speed_radps, double intake_pa, double lambda) const {
    const Eigen::RowVector3d f = (Eigen::RowVector4d(1, speed_radps, intake_pa, lambda) * plane_).array().exp();
    return Blowdown(engine_, *turn_, speed_radps, intake_pa, lambda, {f(0), f(1), f(2)}).run();
}

ExhaustPoint exhaust_point(const EngineFile &engine, double speed_radps, double intake_pa, double lambda) {
    return TrimmedExhaust(engine).point(speed_radps, intake_pa, lambda);
}

namespace {

constexpr double kRpm[SD_AFR_SPEEDS] = {800, 1700, 3000, 4800}, kBar[SD_AFR_PRESSURES] = {0.9, 1.5, 2.5},
                 kLambda[SD_AFR_LAMBDAS] = {0.25, 0.75};
constexpr double kMassCharges = 12; // the manifold never holds the gas of so many cylinders

/// The firmware knows one charge a bar of intake pressure; what it really is here goes into the shares.
sd_afr_node_t page_node(const ExhaustPoint &point, int open_position, double charge_factor) {
    sd_afr_node_t node{};
    const auto cycle = point.share.size();
    for (std::size_t k = 0; k < std::min<std::size_t>(SD_AFR_OPEN, cycle); ++k)
        node.share[k] =
            std::uint16_t(std::lround(65535 * charge_factor * point.share[(std::size_t(open_position) + k) % cycle]));
    node.rate_hz2 = float(point.rate_hz * point.rate_hz);
    node.per_z0 = float(1 / point.z0_kg);
    node.per_transport = point.transport_kg > 0 ? float(1 / point.transport_kg) : 0.0f;
    node.kelvin = float(point.reading.kelvin);
    return node;
}

/// Drift of a coefficient in a cycle beside the noise of a position at 1500 rpm, of lambda: as fast as the document's law,
/// docs/theory/afr.md.
constexpr double kInversionDrift = 0.005, kInversionNoisePerRthz = 1.83e-4;

sd_uego_gains_t inversion_gains(const EngineFile &engine, double rpm) {
    const int positions = 2 * engine.wheel.positions;
    const double step_s = 120 / rpm / positions;
    return uego_gains({engine.exhaust->uego_tau_s[0], engine.exhaust->uego_tau_s[1], step_s, positions,
                       sd_afr_harmonics(std::uint8_t(engine.cylinders())), kInversionNoisePerRthz / std::sqrt(2 * step_s),
                           kInversionDrift});
}

} // namespace

sd_afr_grid_t afr_grid(const EngineFile &engine) {
    sd_afr_grid_t grid{};
    if (!engine.exhaust) return grid;
    grid.present = 1;
    const int open = int(std::floor(engine.exhaust_open_deg / 360 * engine.wheel.positions));
    grid.open_position = std::uint16_t(open);
    const TrimmedExhaust exhaust(engine);
    const double at_bar = kBar[SD_AFR_PRESSURES / 2];
    grid.air_kg_per_bar =
        float(exhaust.point(kRpm[SD_AFR_SPEEDS / 2] * M_PI / 30, at_bar * 1e5, kLambda[0]).air_kg / at_bar);
    for (int s = 0; s < SD_AFR_SPEEDS; ++s) {
        for (int p = 0; p < SD_AFR_PRESSURES; ++p) {
            for (int l = 0; l < SD_AFR_LAMBDAS; ++l) {
                const ExhaustPoint point = exhaust.point(kRpm[s] * M_PI / 30, kBar[p] * 1e5, kLambda[l]);
                grid.node[s][p][l] = page_node(point, open, point.air_kg / (double(grid.air_kg_per_bar) * kBar[p]));
                grid.mass_base_kg = std::max(grid.mass_base_kg, float(kMassCharges * point.charge_kg));
            }
        }
    }
    for (int s = 0; s < SD_AFR_SPEEDS; ++s) {
        grid.speed_radps[s] = float(kRpm[s] * M_PI / 30);
        grid.inversion[s] = inversion_gains(engine, kRpm[s]);
    }
    std::copy(std::begin(kBar), std::end(kBar), grid.pressure_bar);
    std::copy(std::begin(kLambda), std::end(kLambda), grid.lambda);
    grid.dead_s = float(engine.exhaust->dead_time_s);
    grid.tau1_s = float(engine.exhaust->uego_tau_s[0]);
    grid.tau2_s = float(engine.exhaust->uego_tau_s[1]);
    const auto psi = exhaust_psi();
    std::copy(psi.begin(), psi.end(), grid.psi);
    std::transform(psi.begin(), psi.end(), grid.psi_q31, [](double x) { return std::int32_t(std::lround(std::ldexp(x, 31))); });
    grid.behind_bar = float(kAmbientPa / 1e5);
    return grid;
}

std::array<double, 33> exhaust_psi() {
    std::array<double, 33> table{};
    for (std::size_t k = 0; k < table.size(); ++k) table[k] = psi(1 + double(k) / 32);
    return table;
}

} // namespace sixdeg
