// SPDX-License-Identifier: MIT
// Two detectors of misfires as open engine controllers have them in 2026, written anew from what their authors say of them, for
// comparison. Both look at how fast the crank passes one window of angle of each cylinder. Position and phase are given to them.
//
// - Speed delta: the speed in a cylinder's window, less that of the cylinder before it (FOME, issue 174 "Per cylinder RPM delta", window
//   and its phase set by the user). FOME logs it and decides nothing.
// - Running mean: the time that the window takes, less its own running mean of that cylinder, over a running mean of how far such times
//   are usually off (rusEFI, pull request 9662, "idle-based misfire detection via tooth-timing EMA"). rusEFI uses it at idle alone, and
//   demands a number of slow windows among so many, which counts misfires and does not find single ones; so that part is left out. A
//   misfire leaves the crank slower until something drives it again, and the windows behind it are slow too.
#pragma once
#include <vector>

#include "studies/misfire/misfire_set.hpp"

namespace sixdeg {

/// Window of a cylinder, in firing intervals after its TDC.
struct AngleWindow {
    double from, to;
};

/// What did best for both of six windows tried on seeds 101 and 102 (docs/results/misfire-study.md).
constexpr AngleWindow kOpenEcuWindow{0.75, 1.25};

/// A score for each firing of the run, lower where a misfire is likelier: of the speed delta rpm, of the running mean usual distances.
/// NaN where the window is not in the record.
std::vector<double> speed_delta(const SetRun &run, const EngineFile &engine, AngleWindow window = kOpenEcuWindow);
std::vector<double> running_mean(const SetRun &run, const EngineFile &engine, AngleWindow window = kOpenEcuWindow);

} // namespace sixdeg
