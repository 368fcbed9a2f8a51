// SPDX-License-Identifier: MIT
// The commands of the `sixdeg` program. Each lives in a file of its own name and registers itself here.
#pragma once
#include <CLI/App.hpp>

namespace sixdeg {

void add_bench(CLI::App &app);
void add_bench_observers(CLI::App &app); ///< bench-observers: the benchmark of document 000
void add_calibrate(CLI::App &app);
void add_ecu(CLI::App &app);
void add_misfire_trips(CLI::App &app);
void add_parameter(CLI::App &app);
void add_plant(CLI::App &app);
void add_replay(CLI::App &app);
void add_run(CLI::App &app);
void add_sweep(CLI::App &app);
void add_watch(CLI::App &app);
void add_sensors(CLI::App &app); ///< sensors: which sensors observe which states

} // namespace sixdeg
