// SPDX-License-Identifier: MIT
// The commands of the `sixdeg` program. Each lives in a file of its own name and adds itself to the program.
#pragma once
#include <CLI/App.hpp>

namespace sixdeg {

void add_bench(CLI::App &app);
void add_calibrate(CLI::App &app);
void add_ecu(CLI::App &app);
void add_parameter(CLI::App &app);
void add_plant(CLI::App &app);
void add_replay(CLI::App &app);
void add_run(CLI::App &app);
void add_study(CLI::App &app);             ///< study: the group of the next two, and of those that live in its own file.
void add_study_observers(CLI::App &study); ///< study observers: the benchmark of document 000.
void add_study_trips(CLI::App &study);     ///< study trips: false decisions of the misfire monitor.
void add_sweep(CLI::App &app);
void add_watch(CLI::App &app);
void add_sensors(CLI::App &app); ///< sensors: which sensors observe which states

} // namespace sixdeg
