// SPDX-License-Identifier: MIT
// Document 000's benchmark: its observers and ours on its hybrid engine, no fault, misfire known and unknown to
// the observer. Conditions are those of docs/results/observers.md.
#pragma once
#include <string>
#include <vector>

#include "studies/observers/hybrid_plant.hpp"

namespace sixdeg {

/// Gains of the document's observers for one engine.
struct BenchGains {
    double roo_per_s, luenberger_per_s2, sliding_mps3;
};

/// Errors are those of the acceleration, percent of the largest acceleration of the run.
struct BenchRow {
    std::string observer, domain, condition; ///< condition: "no fault", "misfire known", "misfire unknown", "offsets unknown"
    double low_percent, high_percent;           ///< Settled: from 0.6 s on.
    double early_low_percent, early_high_percent; ///< From 0.1 s on.
    double to_two_percent_s, to_one_percent_s;    ///< Last time beyond; the run's length when it never settles.
};

/// One unknown misfire among healthy firings, and the healthy firing after it.
struct IsolatedMisfire {
    double peak_percent, longest_s; ///< Largest error; longest time from a surprising firing to within 1 %.
};

constexpr double kBenchRunS = 1.5;

/// Rows by observer, then condition; of misfires the worst over the four cylinders.
std::vector<BenchRow> run_observer_bench(const HybridEngine &engine, const BenchGains &gains, unsigned seed);
/// The same, with observers that are given the input of another engine than the one that runs.
std::vector<BenchRow> run_observer_bench(const HybridEngine &engine, const HybridEngine &told, const BenchGains &gains, unsigned seed);

/// A point of the document's Figures 1 to 4: FOLSMO beside the truth.
struct FigurePoint {
    double time_s, speed_mps, speed_estimate_mps, accel_mps2, accel_estimate_mps2;
};
/// With misfire the second cylinder in firing order fails from time 0 on; known: the observer's input knows.
std::vector<FigurePoint> figure_trace(const HybridEngine &engine, const BenchGains &gains, unsigned seed, bool misfire, bool known);

IsolatedMisfire run_isolated_misfire(const HybridEngine &engine, unsigned seed);

} // namespace sixdeg
