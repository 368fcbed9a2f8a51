// SPDX-License-Identifier: MIT
// Misfires of an engine whose car shuffles, with and without the driveline's word.
#pragma once
#include <cstdint>

#include "score/misfire_score.hpp"

namespace sixdeg {

/// Load of host_sim/data/scenarios/shuffle.toml, over and over: 1 bar, and 4 bar for a second of every three.
struct ShuffleCase {
    double seconds = 300, speed_rpm = 1000;
    int gear = 2;
    double road_nm = 0; ///< Rms of a rough road's torque at the crank, 3 to 15 Hz.
    bool word = true;   ///< False: nobody tells the gear, so the driveline says nothing.
    std::uint64_t seed = 1;
};
MisfireFigures run_shuffle(const ShuffleCase &shuffle);

} // namespace sixdeg
