// SPDX-License-Identifier: MIT
// The commands of the `sixdeg` program. Each lives in a file of its own name and adds itself to the program.
#pragma once
#include "cli/command_line.hpp"

namespace sixdeg {

void add_bench(Command &app);
void add_calibrate(Command &app);
void add_ecu(Command &app);
void add_identify(Command &app);
void add_parameter(Command &app);
void add_plant(Command &app);
void add_replay(Command &app);
void add_run(Command &app);
void add_study(Command &app);             ///< study: the group of the next four, and of those that live in its own file.
void add_study_observers(Command &study); ///< study observers: the benchmark of document 000.
void add_study_engines(Command &study); ///< study engines: torque on engines that nobody has seen.
void add_study_gas(Command &study);     ///< study gas: the simulated engine's gas, step by step.
void add_study_identify(Command &study); ///< study identify: engines drawn by seed, found again.
void add_study_misfire(Command &study); ///< study misfire: detectors on a made set.
void add_study_trips(Command &study);     ///< study trips: false decisions of the misfire monitor.
void add_sweep(Command &app);
void add_watch(Command &app);
void add_sensors(Command &app); ///< sensors: which sensors observe which states

} // namespace sixdeg
