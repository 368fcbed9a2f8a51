// SPDX-License-Identifier: MIT
#include "plant/engine/fuel_map.hpp"

#include <algorithm>
#include <cmath>

#include "plant/engine/engine_model.hpp"

namespace sixdeg {
namespace {

constexpr double kStepDeg = 1;

PlantEngine single_of(const PlantEngine &engine) {
    PlantEngine single = engine;
    single.shared.firing_order = {1};
    single.shared.firing_tdc_deg = {0};
    single.dual_mass.reset();
    return single;
}

// The nominal cylinder turned at a constant speed; keeps its tables between trials.
class Trial {
  public:
    explicit Trial(const PlantEngine &engine)
        : model_(single_of(engine), {{engine.shared.compression_ratio}}, kStepDeg) {}

    // Second cycle after a start at gas exchange TDC: the first has forgotten how it began.
    CycleTruth run(double speed_radps, double intake_pa, double fuel_kg) {
        model_.set_intake_pressure(0, intake_pa);
        model_.start(0, model_.tables().steps / 2, 0, speed_radps);
        model_.prescribe_speed(speed_radps, 0);
        for (int step = 0; step < 2 * model_.tables().steps; ++step) {
            model_.step();
            for (const Event *e = model_.events_begin(); e != model_.events_end(); ++e) {
                Charge charge;
                charge.fuel_kg = fuel_kg;
                if (e->kind == EventKind::intake_close) model_.set_charge(0, charge);
            }
        }
        return model_.finished(0);
    }

  private:
    EngineModel model_;
};

struct Solved {
    double fuel_kg, motored_imep_pa;
    bool reached;
};

// IMEP is nearly straight in fuel, so the secant from no fuel lands in a few trials.
Solved solve(Trial &trial, const PlantEngine &engine, double speed, double bmep) {
    const double intake = engine.intake_pressure_pa.at(bmep), target = bmep + engine.fmep_at_pa(speed);
    const CycleTruth motored = trial.run(speed, intake, 0);
    const double most = motored.air_kg / engine.stoichiometric_ratio;
    double fuel0 = 0, imep0 = motored.imep_pa;
    double fuel1 =
        std::min(most, 0.8 * most * std::min(1.0, (target - imep0) / (10 * kPaPerBar)) + 0.1 * most);
    for (int i = 0; i < 30; ++i) {
        const double imep1 = trial.run(speed, intake, fuel1).imep_pa;
        if (std::abs(imep1 - target) <= 1e-9 * std::abs(target) + 1e-6) return {fuel1, motored.imep_pa, true};
        if (fuel1 == most && imep1 < target) return {most, motored.imep_pa, false};
        const double next = fuel1 + (target - imep1) * (fuel1 - fuel0) / (imep1 - imep0);
        fuel0 = fuel1, imep0 = imep1;
        fuel1 = std::clamp(next, 0.0, most);
        if (fuel1 == fuel0) break;
    }
    return {fuel1, motored.imep_pa, fuel1 < most};
}

} // namespace

FuelMap::FuelMap(const PlantEngine &engine, double speed_low_radps, double speed_high_radps,
                 double bmep_top_pa)
    : speed_low_(speed_low_radps), speed_span_(speed_high_radps - speed_low_radps), bmep_top_(bmep_top_pa),
      speeds_(speed_span_ > 0 ? 3 : 1) {
    Trial trial(engine);
    for (int s = 0; s < speeds_; ++s) {
        for (int l = 0; l < kLoads; ++l) {
            const double speed = speed_low_ + speed_span_ * s / 2, bmep = bmep_top_ * l / (kLoads - 1);
            const Solved solved = solve(trial, engine, speed, bmep);
            fuel_.push_back(solved.fuel_kg);
            motored_.push_back(solved.motored_imep_pa);
            reaches_ = reaches_ && solved.reached;
        }
    }
}

double FuelMap::interpolate(const std::vector<double> &table, double speed_radps, double bmep_pa) const {
    const double s =
        speeds_ > 1 ? std::clamp((speed_radps - speed_low_) / speed_span_, 0.0, 1.0) * (speeds_ - 1) : 0;
    const double l = bmep_top_ > 0 ? std::clamp(bmep_pa / bmep_top_, 0.0, 1.0) * (kLoads - 1) : 0;
    const int s0 = std::min(int(s), std::max(speeds_ - 2, 0)), s1 = std::min(s0 + 1, speeds_ - 1),
              l0 = std::min(int(l), kLoads - 2);
    const auto at = [&](int i, int j) { return table[std::size_t(i * kLoads + j)]; };
    const double fs = s - s0, fl = l - l0;
    return (1 - fs) * ((1 - fl) * at(s0, l0) + fl * at(s0, l0 + 1)) +
           fs * ((1 - fl) * at(s1, l0) + fl * at(s1, l0 + 1));
}

double FuelMap::largest_bmep_pa(const PlantEngine &engine, double speed_radps, double limit_pa) {
    Trial trial(engine);
    if (solve(trial, engine, speed_radps, limit_pa).reached) return limit_pa;
    double low = 0, high = limit_pa;
    while (high - low > 0.01 * high) {
        const double middle = (low + high) / 2;
        (solve(trial, engine, speed_radps, middle).reached ? low : high) = middle;
    }
    return low;
}

} // namespace sixdeg
