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

/// gamma_of() by a cubic through four neighbours 2 K apart, 1e-12 off: two exponentials cost more than all the rest of a step.
double gamma_at(double t) {
    constexpr double kFirst = 200, kApart = 2;
    constexpr int kPoints = 2402;
    static const std::vector<double> table = [] {
        std::vector<double> values;
        for (int i = 0; i < kPoints; ++i) values.push_back(gamma_of(kFirst + kApart * i));
        return values;
    }();
    const double at = (t - kFirst) / kApart;
    if (!(at >= 1 && at < kPoints - 2)) return gamma_of(t);
    const auto i = std::size_t(at);
    const double x = at - double(i), before = table[i - 1], here = table[i], next = table[i + 1], after = table[i + 2];
    return here + x * ((next - before) / 2 - (after - 3 * (next - here) - before) / 6 +
                       x * ((before - 2 * here + next) / 2 + x * (after - 3 * (next - here) - before) / 6));
}

/// What the pressure of a shut cylinder changes by at one angle, apart from pressure and charge.
struct Place {
    double volume, volume_slope, wall, burn; ///< m3; m3/rad; of the wall loss; 1/rad of the heat.
    bool shut;
};

struct FineStep {
    double h;
    Place from, middle;
};

/// What is in the cylinder, and around it.
struct Charge {
    double intake_pa, exhaust_pa, heat_j, kelvin_per_joule, wall, exponent;
};

/// Everything that depends on angle only is computed once, for as many charges as are wanted.
class Cylinder {
  public:
    Cylinder(const EngineFile &engine, std::size_t lane) : engine_(engine), crank_(engine, engine.compression_factor(lane)) {}

    double volume(double a) const { return crank_.volume(a); }
    double closing() const { return engine_.intake_close_deg * kRadPerDeg - 4 * M_PI; } // before TDC
    double opening() const { return engine_.exhaust_open_deg * kRadPerDeg; }

    /// kFine steps on from angle `a` to `to`; the last ones may end beyond the opening.
    void walk(double &a, double to, std::vector<FineStep> &steps) const {
        const double h = (to - a) / kFine;
        for (int fine = 0; fine < kFine; ++fine, a += h) steps.push_back({h, place(a), place(a + h / 2)});
    }
    std::vector<FineStep> steps_to_opening() const {
        std::vector<FineStep> steps;
        for (double a = closing(); a < opening() - 1e-9;) walk(a, std::fmin(a + kFine * kStep, opening()), steps);
        return steps;
    }
    double arm(double a) const { return crank_.volume_slope(a); }

    /// Hohenberg: h = 130 V^-0.06 p^0.8 T^-0.4 (c_m + 1.4)^0.8 W/(m2 K), p in bar, c_m the mean piston speed. T is as p V.
    Charge charge(const PulseConditions &at, bool fired) const {
        const double intake = at.intake_bar * 1e5, closed = volume(closing()), piston_mps = engine_.stroke_m * at.speed_radps / M_PI;
        const double air = intake * closed / (kGasConstant * at.charge_k), kelvin = at.charge_k / (intake * closed);
        const double wall = at.wall_factor * 130 * std::pow(1e-5, 0.8) * std::pow(kelvin, -0.4) * std::pow(piston_mps + 1.4, 0.8);
        return {intake, at.exhaust_bar * 1e5, fired ? at.equivalence_ratio * air * kHeatPerAir : 0, kelvin, wall / at.speed_radps,
                at.exponent};
    }

    static void advance(const FineStep &step, const Charge &charge, double &p) {
        const double middle = p + step.h / 2 * slope(step.from, charge, p);
        p += step.h * slope(step.middle, charge, middle);
    }
    /// From point to point once the exhaust valve is open.
    static void breathe(double &a, double to, const Charge &charge, double &p) {
        const double h = (to - a) / kFine;
        const auto slope_at = [&](double angle, double pa) {
            return kExchangePerRad * ((angle < 2 * M_PI ? charge.exhaust_pa : charge.intake_pa) - pa);
        };
        for (int fine = 0; fine < kFine; ++fine, a += h) {
            const double middle = p + h / 2 * slope_at(a, p);
            p += h * slope_at(a + h / 2, middle);
        }
    }

  private:
    static double slope(const Place &at, const Charge &charge, double p) {
        if (!at.shut) return kExchangePerRad * (charge.exhaust_pa - p);
        const double t = charge.kelvin_per_joule * p * at.volume, gamma = gamma_at(t) + charge.exponent;
        const double loss = charge.wall * at.wall * std::pow(p, 0.4) * (t - kWallK);
        return ((gamma - 1) * (charge.heat_j * at.burn - loss) - gamma * p * at.volume_slope) / at.volume;
    }
    Place place(double a) const {
        if (a > opening()) return {1, 0, 0, 0, false};
        const double v = volume(a), liner = 4 * (v - crank_.clearance) / engine_.bore_m;
        return {v, crank_.volume_slope(a), std::pow(v, -0.46) * (2 * crank_.area + liner), burn_rate(a), true};
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
};

/// Torque of a cylinder over a cycle, for any charge.
class Cycle {
  public:
    Cycle(const EngineFile &engine, std::size_t lane) : cylinder_(engine, lane), first_(int(std::ceil(cylinder_.closing() / kStep))) {
        shut_to_ = cylinder_.closing();
        for (int i = first_; shut_to_ <= cylinder_.opening(); ++i) {
            cylinder_.walk(shut_to_, i * kStep, shut_);
            arm_.push_back(cylinder_.arm(shut_to_));
        }
        for (int i = first_ + int(arm_.size()); i < first_ + kPulsePoints; ++i) arm_.push_back(cylinder_.arm(i * kStep));
    }

    /// From intake closing, one cycle round, torque at every point of the table.
    std::vector<double> torque(const PulseConditions &at, bool fired) const {
        const Charge charge = cylinder_.charge(at, fired);
        std::vector<double> table(kPulsePoints);
        double p = charge.intake_pa, a = shut_to_;
        for (int i = 0; i < kPulsePoints; ++i) {
            const auto step = std::size_t(i * kFine);
            if (step < shut_.size()) {
                for (int fine = 0; fine < kFine; ++fine) Cylinder::advance(shut_[step + std::size_t(fine)], charge, p);
            } else {
                Cylinder::breathe(a, (first_ + i) * kStep, charge, p);
            }
            table[std::size_t((first_ + i + kPulsePoints) % kPulsePoints)] = (p - kCrankcase) * arm_[std::size_t(i)];
        }
        return table;
    }

  private:
    Cylinder cylinder_;
    int first_; ///< Point of the table that the first steps lead to.
    double shut_to_;
    std::vector<FineStep> shut_; ///< kFine to each point.
    std::vector<double> arm_;    ///< dV/da where the steps to each point end.
};

} // namespace

std::function<double(const PulseConditions &)> exhaust_opening(const EngineFile &engine) {
    const Cylinder cylinder(engine, 0);
    return [cylinder, steps = cylinder.steps_to_opening()](const PulseConditions &conditions) {
        const Charge charge = cylinder.charge(conditions, true);
        double p = charge.intake_pa;
        for (const FineStep &step : steps) Cylinder::advance(step, charge, p);
        return p;
    };
}

namespace {

/// Fired less motored; its mean over the 180 deg after TDC is 1.
std::vector<double> combustion(const Cycle &cycle, const PulseConditions &conditions, const std::vector<double> &motored) {
    auto pulse = cycle.torque(conditions, true);
    double mean = 0;
    for (int i = 0; i < kPulsePoints; ++i) {
        pulse[std::size_t(i)] -= motored[std::size_t(i)];
        if (i < kPulsePoints / 4) mean += pulse[std::size_t(i)] / (kPulsePoints / 4);
    }
    for (double &torque : pulse) torque /= mean;
    return pulse;
}

CylinderPulse pulse_of(const Cycle &cycle, const PulseConditions &conditions) {
    PulseConditions doubled_intake = conditions;
    doubled_intake.intake_bar *= 2;
    const auto once = cycle.torque(conditions, false), doubled = cycle.torque(doubled_intake, false);
    CylinderPulse pulse{combustion(cycle, conditions, once), {}, {}};
    for (std::size_t k = 0; k < std::size_t(kPulsePoints); ++k) {
        pulse.motored_per_bar.push_back((doubled[k] - once[k]) / conditions.intake_bar);
        pulse.motored_rest.push_back(2 * once[k] - doubled[k]);
    }
    return pulse;
}

} // namespace

CylinderPulse cylinder_pulse(const EngineFile &engine, std::size_t lane, const PulseConditions &conditions) {
    return pulse_of(Cycle(engine, lane), conditions);
}

std::vector<CylinderPulse> cylinder_pulses(const EngineFile &engine, const std::vector<PulseConditions> &conditions) {
    const Cycle cycle(engine, 0);
    std::vector<CylinderPulse> pulses;
    for (const PulseConditions &at : conditions) pulses.push_back(pulse_of(cycle, at));
    return pulses;
}

std::vector<double> pulse_bend(const EngineFile &engine, std::size_t lane, const CylinderPulse &pulse) {
    PulseConditions doubled_loss;
    doubled_loss.wall_factor *= 2;
    const Cycle cycle(engine, lane);
    auto bend = combustion(cycle, doubled_loss, cycle.torque(doubled_loss, false));
    for (std::size_t k = 0; k < bend.size(); ++k) bend[k] -= pulse.combustion[k];
    return bend;
}

std::vector<double> motored_over_exponent(const EngineFile &engine, std::size_t lane) {
    constexpr double kChange = 0.02;
    const Cycle cycle(engine, lane);
    PulseConditions more, less;
    more.exponent = kChange, less.exponent = -kChange;
    const auto high = pulse_of(cycle, more).motored_per_bar, low = pulse_of(cycle, less).motored_per_bar;
    std::vector<double> slope(high.size());
    for (std::size_t k = 0; k < slope.size(); ++k) slope[k] = (high[k] - low[k]) / (2 * kChange);
    return slope;
}

std::size_t like_cylinder(const EngineFile &engine, std::size_t lane) {
    std::size_t first = 0;
    while (engine.compression_factor(first) != engine.compression_factor(lane)) ++first;
    return first;
}

double pulse_at(const std::vector<double> &table, double angle_rad) {
    const double at = angle_rad / kStep, floor = std::floor(at);
    const auto n = std::int64_t(table.size()), k = ((std::int64_t(floor) % n) + n) % n;
    return table[std::size_t(k)] + (at - floor) * (table[std::size_t((k + 1) % n)] - table[std::size_t(k)]);
}

} // namespace sixdeg
