// SPDX-License-Identifier: MIT
// Misfires nobody told of, on the simulated engine: the observers of document 000 in the ecu, the observer of every cylinder's
// input, and the monitor, all on the same teeth. One simulated run; its events are given to one ecu after the other.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "loop/bench_run.hpp"

namespace sixdeg {

/// An operating point; with `ramp` the speed rises and falls by a fifth of it, the whole way in 4 s.
struct DetectionCell {
    int rpm;
    double bmep_bar;
    bool ramp;
};

/// The eight cells of docs/results/observers.md, steady and in the ramp.
std::vector<DetectionCell> detection_cells();

/// One misfire in 50, cyclic variation 5 %, jitter 0.01 deg, the diesel; at 900 rpm with three times its inertia, since it would
/// stop at a misfire.
Scenario detection_scenario(const DetectionCell &cell, int cycles, std::uint64_t seed);

struct DetectionRow {
    std::string method;
    MisfireFigures figures;
};

struct Detection {
    std::vector<DetectionRow> rows;
    std::uint64_t compared = 0, differing = 0; ///< Firings of the three observers that both number types judged; of them unlike.
    RunResult run;                             ///< With the monitor.
};

/// `parameters`: changes of the tune, KEY=VALUE.
Detection run_detection(const Scenario &scenario, const std::vector<std::string> &parameters);

} // namespace sixdeg
