// SPDX-License-Identifier: MIT
#include "design/torque/pulse.hpp"

#include <cmath>

#include "design/crank/slider_crank.hpp"

namespace sixdeg {
namespace {

constexpr double kRadPerDeg = M_PI / 180, kStep = 4 * M_PI / kPulsePoints;
constexpr double kCrankcase = 1.013e5;                    // Pa
constexpr double kExchangePerRad = 6;                     // of the pressure of an open cylinder
constexpr double kGasConstant = 287, kHeatPerAir = 42.7e6 / 14.6; // J/(kg K); J/kg, stoichiometric
constexpr double kWallK = 430;
constexpr int kFine = 8;                                  // integration steps a point

/// 1 + R/c_v of air: 5/2 R of a rigid diatomic molecule and the vibration of nitrogen and oxygen.
double gamma_of(double t) {
    const auto vibration = [t](double theta) {
        const double x = theta / t, e = std::exp(-x);
        return x * x * e / ((1 - e) * (1 - e));
    };
    return 1 + 1 / (2.5 + 0.78 * vibration(3390) + 0.21 * vibration(2270));
}

class Cylinder {
  public:
    Cylinder(const EngineFile &engine, std::size_t lane, const PulseConditions &at, double heat_j)
        : engine_(engine), crank_(engine, engine.compression_factor(lane)), at_(at), intake_(at.intake_bar * 1e5), heat_(heat_j) {}

    double volume(double a) const { return crank_.volume(a); }
    double closing() const { return engine_.intake_close_deg * kRadPerDeg - 4 * M_PI; } // before TDC
    double opening() const { return engine_.exhaust_open_deg * kRadPerDeg; }

    double slope(double a, double p) const {
        if (a > opening()) return kExchangePerRad * ((a < 2 * M_PI ? at_.exhaust_bar * 1e5 : intake_) - p);
        const double t = at_.charge_k * p * volume(a) / (intake_ * volume(closing()));
        const double gamma = gamma_of(t);
        return ((gamma - 1) * (heat_ * burn_rate(a) - wall_loss(a, p, t)) - gamma * p * crank_.volume_slope(a)) / volume(a);
    }

    /// Pressure that the exhaust valve opens at.
    double pressure_at_opening() const {
        double a = closing(), p = intake_;
        while (a < opening() - 1e-9) advance(a, p, std::fmin(a + kFine * kStep, opening()));
        return p;
    }

    /// From intake closing, one cycle round, torque at every point of the table.
    std::vector<double> torque() const {
        std::vector<double> table(kPulsePoints);
        const int first = int(std::ceil(closing() / kStep));
        double a = closing(), p = intake_;
        for (int i = first; i < first + kPulsePoints; ++i) {
            advance(a, p, i * kStep);
            table[std::size_t((i + kPulsePoints) % kPulsePoints)] = (p - kCrankcase) * crank_.volume_slope(a);
        }
        return table;
    }

  private:
    void advance(double &a, double &p, double to) const {
        const double h = (to - a) / kFine;
        for (int fine = 0; fine < kFine; ++fine, a += h) {
            const double middle = p + h / 2 * slope(a, p);
            p += h * slope(a + h / 2, middle);
        }
    }

    /// J/rad; Hohenberg: h = 130 V^-0.06 p^0.8 T^-0.4 (c_m + 1.4)^0.8 W/(m2 K), p in bar, c_m the mean piston speed.
    double wall_loss(double a, double p, double t) const {
        const double piston_mps = engine_.stroke_m * at_.speed_radps / M_PI;
        const double h = 130 * std::pow(volume(a), -0.06) * std::pow(p / 1e5, 0.8) * std::pow(t, -0.4) *
                         std::pow(piston_mps + 1.4, 0.8);
        const double liner = 4 * (volume(a) - crank_.clearance) / engine_.bore_m;
        return at_.wall_factor * h * (2 * crank_.area + liner) * (t - kWallK) / at_.speed_radps;
    }
    double burn_rate(double a) const {
        double rate = 0;
        for (const HeatPulse &pulse : engine_.pulses) {
            const double duration = pulse.duration_deg * kRadPerDeg, y = (a - pulse.start_deg * kRadPerDeg) / duration;
            if (y <= 0) continue;
            const double left = std::log(1000.0) * std::pow(y, pulse.shape + 1);
            rate += pulse.share * (pulse.shape + 1) * left / (y * duration) * std::exp(-left);
        }
        return rate;
    }

    const EngineFile &engine_;
    SliderCrank crank_;
    PulseConditions at_;
    double intake_, heat_;
};

double heat_j(const EngineFile &engine, std::size_t lane, const PulseConditions &at) {
    const Cylinder cylinder(engine, lane, at, 0);
    const double air = at.intake_bar * 1e5 * cylinder.volume(cylinder.closing()) / (kGasConstant * at.charge_k);
    return at.equivalence_ratio * air * kHeatPerAir;
}

} // namespace

double exhaust_opening_pa(const EngineFile &engine, const PulseConditions &conditions) {
    return Cylinder(engine, 0, conditions, heat_j(engine, 0, conditions)).pressure_at_opening();
}

namespace {

/// Fired less motored; its mean over the 180 deg after TDC is 1.
std::vector<double> combustion(const EngineFile &engine, std::size_t lane, const PulseConditions &conditions, const std::vector<double> &motored) {
    auto pulse = Cylinder(engine, lane, conditions, heat_j(engine, lane, conditions)).torque();
    double mean = 0;
    for (int i = 0; i < kPulsePoints; ++i) {
        pulse[std::size_t(i)] -= motored[std::size_t(i)];
        if (i < kPulsePoints / 4) mean += pulse[std::size_t(i)] / (kPulsePoints / 4);
    }
    for (double &torque : pulse) torque /= mean;
    return pulse;
}

} // namespace

CylinderPulse cylinder_pulse(const EngineFile &engine, std::size_t lane, const PulseConditions &conditions) {
    PulseConditions doubled_intake = conditions;
    doubled_intake.intake_bar *= 2;
    const auto once = Cylinder(engine, lane, conditions, 0).torque(), doubled = Cylinder(engine, lane, doubled_intake, 0).torque();
    CylinderPulse pulse{combustion(engine, lane, conditions, once), {}, {}};
    for (std::size_t k = 0; k < std::size_t(kPulsePoints); ++k) {
        pulse.motored_per_bar.push_back((doubled[k] - once[k]) / conditions.intake_bar);
        pulse.motored_rest.push_back(2 * once[k] - doubled[k]);
    }
    return pulse;
}

std::vector<double> pulse_bend(const EngineFile &engine, std::size_t lane, const CylinderPulse &pulse) {
    PulseConditions doubled_loss;
    doubled_loss.wall_factor *= 2;
    auto bend = combustion(engine, lane, doubled_loss, Cylinder(engine, lane, doubled_loss, 0).torque());
    for (std::size_t k = 0; k < bend.size(); ++k) bend[k] -= pulse.combustion[k];
    return bend;
}

double pulse_at(const std::vector<double> &table, double angle_rad) {
    const double at = angle_rad / kStep, floor = std::floor(at);
    const auto n = std::int64_t(table.size()), k = ((std::int64_t(floor) % n) + n) % n;
    return table[std::size_t(k)] + (at - floor) * (table[std::size_t((k + 1) % n)] - table[std::size_t(k)]);
}

} // namespace sixdeg
