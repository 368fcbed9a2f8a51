// SPDX-License-Identifier: MIT
// What `sixdeg bench` can time. Each adds its benchmarks to google-benchmark's list; the command runs and prints them.
#pragma once

namespace sixdeg {

void add_block_benches(); ///< The firmware's blocks, named BLOCK|f32 and BLOCK|q31.
void add_dense_benches(); ///< The same work with Eigen's dense matrices, named BLOCK|dense.
void add_plant_benches(); ///< The simulated engine, with `times_real_time`.

/// Of a crank edge, with the samples and clock events before it.
struct ToothTime {
    double average_us;
    double worst_us; ///< Of one edge: the largest of all edges' medians over repetitions.
};
/// The whole ecu with document 000's FOLSMO and document 004's chain, beside all that always runs; fixed_point: the Fourier observer,
/// FOLSMO and the chain in q31.
ToothTime time_of_tooth(bool fixed_point, int repetitions);

} // namespace sixdeg
