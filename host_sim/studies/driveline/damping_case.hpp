// SPDX-License-Identifier: MIT
// Active damping of a tip-out: the request of firmware/driveline/sd_driveline_damping.h through an engine that is late.
#pragma once
#include "sd_driveline_damping.h"
#include "studies/driveline/drive_case.hpp"

namespace sixdeg {

struct DampingCase {
    DriveCase drive = usual_drive();
    sd_driveline_damping_config_t damping{20, 25, 1000, 4000, 0};
    double dead_time_s = 0.015, lag_s = 0.01; ///< Of the engine: until the next combustions, and until they are felt.
    double lowest_nm = -15, highest_nm = 120; ///< What the engine can give.
    double wrong_at_s = 0;                    ///< When the filter's torsion is put into another location; 0: never.
};

struct DampingFigures {
    double second_swing_nm = 0; ///< Torque of the shaft at the crank, from the second crest behind the tip-out's trough to the next trough.
    double largest_request_nm = 0;
    double off_after_s = -1; ///< From wrong_at_s until the request is 0; below 0: never.
    double told_percent = 0;
};
/// 40 N m until 3 s, then coasting within 50 ms; 1800 rpm in second gear; 6 s.
DampingFigures run_damping(const DampingCase &damping);

} // namespace sixdeg
