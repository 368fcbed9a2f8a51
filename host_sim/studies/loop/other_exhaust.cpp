// SPDX-License-Identifier: MIT
#include "studies/loop/other_exhaust.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/progress.hpp"
#include "common/random.hpp"
#include "studies/loop/loop_case.hpp"

namespace sixdeg {
namespace {

constexpr int kStepCycle = 60, kScored = int(kScoredCycles);
constexpr std::uint64_t kKindSeeds = 1000; ///< Added to the seed of an exhaust, so that its draws are none of the run's own.

struct Point {
    const char *name;
    double rpm, bmep_bar, goal;
    int after; ///< Cycles after the step from which errors count.
};

/// The firmware as it is, +20 % on cylinder 1, the sensor's noise 0.5 % a step of 6 deg.
AfrFigures after_step(const Point &p, std::uint64_t seed, const std::vector<std::string> &tune, bool other, bool quiet) {
    const double cycle_s = 120 / p.rpm, step_s = 1 / p.rpm;
    LoopCase loop;
    loop.scenario = {fmt::format("speed.rpm={}", p.rpm), fmt::format("load.bmep_bar={}", p.bmep_bar), "cylinders.fuel_percent=[0, 0, 0, 0]",
                     fmt::format("cylinders.fuel_step=[{{at_s={}, cylinder=1, percent=20}}]", (kStepCycle + 0.25) * cycle_s),
                     fmt::format("run.duration_s={}", (kStepCycle + 2 + p.after + kScored) * cycle_s), "control.balance_on_s=[1000, 1001]",
                     "cyclic.cov_percent=0", fmt::format("uego.noise_per_rthz={}", quiet ? 0 : 0.005 * std::sqrt(2 * step_s))};
    loop.tune = tune, loop.seed = seed;
    if (other) loop.change = [&](PlantEngine &engine) { make_other_exhaust(engine, p.rpm, seed); };
    return run_loop(loop).afr.value();
}

double rms(const std::vector<double> &x) {
    double sum = 0;
    for (double v : x) sum += v * v / double(x.size());
    return std::sqrt(sum);
}

} // namespace

void make_other_exhaust(PlantEngine &engine, double rpm, std::uint64_t seed) {
    RandomStream random(seed + kKindSeeds, 11);
    const auto within = [&](double low, double high) { return low + (high - low) * random.uniform(); };
    engine.gas_cv_over_r = {1 / (within(1.30, 1.38) - 1), 0, 0};
    engine.wall_factor = within(0, 2);
    for (PulseShape &pulse : engine.pulses) {
        pulse.start_rad += within(-4, 4) * kRadPerDeg;
        pulse.duration_rad *= within(0.8, 1.3);
        pulse.shape_m *= within(0.7, 1.4);
    }
    engine.exhaust.wall_wpk = engine.exhaust.back_pressure_pa = engine.exhaust.turbine_swallow_drop = 0;
    ExhaustSystem &exhaust = *engine.shared.exhaust;
    exhaust.turbine_area_m2 = Profile(within(0.85, 1.2) * exhaust.turbine_area_m2.at(rpm * kRadpsPerRpm));
    exhaust.readings.clear();
}

void print_other_exhausts(int seeds, const std::vector<std::string> &tune) {
    fmt::print("\n{:<44}{:>8}{:>8}{:>10}{:>8}{:>8}{:>8}\n", "+20 % on cylinder 1, points, rms of all seeds", "own", "other", "quietly",
               "worst", "stated", "goal");
    for (const Point &p : {Point{"1500 rpm, 9 bar, from 4 cycles on", 1500, 9, 1.3, 4},
                           {"1000 rpm, 3 bar, from 4 cycles on", 1000, 3, 1.8, 4},
                           {"2500 rpm, 9 bar, from 8 cycles on", 2500, 9, 2.5, 8}}) {
        std::vector<double> own, other, quiet, stated;
        Progress progress("seed", seeds);
        for (int seed = 1; seed <= seeds; ++seed, progress.next()) {
            own.push_back(after_step(p, std::uint64_t(seed), tune, false, false).rms_points);
            const AfrFigures f = after_step(p, std::uint64_t(seed), tune, true, false);
            other.push_back(f.rms_points), stated.push_back(f.stated_points);
            quiet.push_back(after_step(p, std::uint64_t(seed), tune, true, true).rms_points);
        }
        fmt::print("{:<44}{:>8.2f}{:>8.2f}{:>10.2f}{:>8.2f}{:>8.2f}{:>8.1f}\n", p.name, rms(own), rms(other), rms(quiet),
                   *std::max_element(other.begin(), other.end()), rms(stated), p.goal);
    }
}

void print_at_rest(int seeds, const std::vector<std::string> &tune) {
    std::vector<double> error, stated, bias;
    Progress progress("seed", seeds);
    for (int seed = 1; seed <= seeds; ++seed, progress.next()) {
        const AfrFigures f = run_loop({{"run.duration_s=35"}, tune, 0, false, std::uint64_t(seed),
                                       "figure16_1500rpm_9bar.toml"}).afr.value();
        error.push_back(f.rms_points), stated.push_back(f.stated_points);
        bias.resize(f.bias_by_cylinder.size());
        for (std::size_t i = 0; i < bias.size(); ++i) bias[i] += f.bias_by_cylinder[i] / seeds;
    }
    fmt::print("\nat rest, 14 s after a step of 13 %, {} seeds, points: rms {:.2f} (goal 0.5), stated {:.2f}; "
               "mean error of cylinders 1 to {}:",
               seeds, rms(error), rms(stated), bias.size());
    for (double b : bias) fmt::print(" {:+.2f}", b);
    fmt::print(" (goal 0.3)\n");
}

} // namespace sixdeg
