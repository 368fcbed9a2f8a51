// SPDX-License-Identifier: MIT
// What a full air path is put through: wandering operation with a wrong calibration, faults, load steps and ramps of speed.
#pragma once
#include <string>
#include <vector>

#include "studies/airpath/full_run.hpp"

namespace sixdeg {

constexpr double kParameterError = 0.02; ///< Of each value of the engine and each meter, any within being as likely.

/// 1500 rpm, 8 bar, valve at 0.35, vanes at 0.44, or what is given, each wandering as document 001's figures have it: 60 rpm, 6 % of the
/// load,
/// 0.05 and 0.04 of the strokes. The engine is off by draws of kParameterError.
FullCase wandering(double seconds, std::uint64_t seed, double bmep_pa = 8e5);

/// Right after what it is now, the load makes a step at from_s and one back at to_s.
void add_load_step(FullCase &c, double from_s, double to_s, double bmep_pa);

/// A fault, and the actuator that may be named for it.
struct FaultCase {
    std::string name;
    std::vector<airpath::Fault> faults; ///< From 0 s; the study shifts them.
    int may_name;                       ///< sd_airpath_fault_t; SD_AIRPATH_NO_FAULT: none; SD_AIRPATH_UNCLEAR: that both are faulty.
    bool moving = false;                ///< Valve and vanes are moved by 0.1, so that a stuck one matters.
};

/// The steps that delays are measured on, as document 001 has them: valve opening, vanes closing.
std::vector<FaultCase> step_cases();
/// Stuck, slow, intermittent and drifting actuators, biased sensors, leaks, both actuators at once.
std::vector<FaultCase> other_cases();

} // namespace sixdeg
