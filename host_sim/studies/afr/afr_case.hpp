// SPDX-License-Identifier: MIT
// What the tables of `sixdeg study afr` run: the plant at an operating point with a fuel step, and what a calibration that is
// right, or off by known amounts, makes of the sensor. Figures by the definitions of docs/results/afr.md.
#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "studies/afr/afr_judge.hpp"

namespace sixdeg::afr_study {

constexpr int kStepCycle = 50, kLanes = 4; ///< The fuel steps at this cycle; cylinders.

struct Case {
    const char *name;
    double rpm, bmep_bar, tau1_ms, tau2_ms, noise; ///< noise: rms of lambda a position, of the mean.
    int cycles;            ///< The goal's, to settle in.
    double intake_bar = 0; ///< 0: the engine file's.
    double slow_s = 0;     ///< Slow mode, scored from so long after the step on.
    int run_cycles() const { return kStepCycle + 34 + int((slow_s > 0 ? slow_s + 5 : 0) * rpm / 120); }
    /// Cycles after the step from which errors count.
    int scored_from() const { return slow_s > 0 ? int(slow_s * rpm / 120) : cycles; }
};

/// The goals' operating points; those with load also as rich as the goals' engine was.
std::vector<Case> step_cases();
/// The first `most` of some cases.
std::vector<Case> first_of(std::vector<Case> cases, int most);

/// A run of the plant with a fuel step on cylinder 1 (0: none) and what the calibration makes of it.
struct Run {
    Run(const Case &c, double percent, const std::vector<std::string> &changes = {},
        const std::function<void(PlantEngine &)> &change_plant = [](PlantEngine &) {});
    AfrEstimates run(const AfrSetup &setup, const std::vector<double> &noise = {}) const;
    /// Of a cylinder's lambda at the end of `cycle` against the true one at the end of the run; points, 0.01 of the mean.
    double error(const AfrEstimates &e, std::size_t cycle, std::size_t lane) const;
    /// Cycles from the first stepped exhaust until every error, less its mean at the end, stays within 5 % of the step.
    double settle(const AfrEstimates &e) const;
    /// Cycles until every error, bias included, stays within 20 % of the step, noise free; and the largest that is left in the end.
    double band_cycles(const AfrEstimates &e) const;
    double largest_left(const AfrEstimates &e) const;

    EngineFile engine;
    AfrTrace trace;
    ExhaustPoint point;
    double mean = 0, step_points = 0; ///< Of lambda at the end; of cylinder 1, points.
    std::size_t at = 0;               ///< Position of the first exhaust with the step.
};

/// The same point while a probe of the ecu's size and pace runs on cylinder 1.
struct Probe {
    explicit Probe(const Case &c);
    std::vector<std::array<double, 8>> trims; ///< By lane, cylinder 1 first.
    Run run;
};

/// The defaults of the parameters afr.*, for every case alike.
AfrSetup setup_for(const Run &run, const Case &c);
/// What a calibration may be off by: flow 5 %, lags 20 %, delay 10 deg, drawn evenly.
AfrError drawn_error(std::uint64_t seed);
/// A calibration that is off, and knows by how much it may be; or what a probe (nullptr: none) makes of it.
void perturb(AfrSetup &setup, const Case &c, int seed, const Probe *probe);

} // namespace sixdeg::afr_study
