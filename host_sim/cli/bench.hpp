// SPDX-License-Identifier: MIT
// What `sixdeg bench` can time. Each adds its benchmarks to google-benchmark's list; the command runs and prints them.
#pragma once

namespace sixdeg {

void add_block_benches(); ///< The firmware's blocks, ns a call, and a dense version of the torque observer beside them.
void add_plant_benches(); ///< The simulated engine, with `times_real_time`.

} // namespace sixdeg
