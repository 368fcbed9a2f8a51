// SPDX-License-Identifier: MIT
// False decisions of the misfire monitor over many trips of a healthy engine.
//
// The firmware's monitor itself judges, but its firings are drawn, not simulated: each index on its own, normal about 1
// with the standard deviation that a run measured. A trip is one start and so many revolutions at one operating point, on
// one road; the monitor learns anew in each.
#pragma once
#include <cstdint>

extern "C" {
#include "sd_misfire.h"
}

namespace sixdeg {

struct TripPlan {
    double healthy_sd; ///< Of the index.
    double stated_sd;  ///< Of the torque, as a share of what is expected.
    std::uint64_t trips, revolutions, seed;
};

struct TripFigures {
    std::uint64_t firings = 0, false_alarms = 0; ///< Healthy ones; of them called misfires.
    std::uint64_t windows_200 = 0, windows_1000 = 0; ///< Exceeded.
    std::uint64_t pending = 0, lamp = 0;             ///< Trips that end with the lamp so; on or blinking.
};

TripFigures run_trips(const sd_misfire_config_t &config, const TripPlan &plan);

} // namespace sixdeg
