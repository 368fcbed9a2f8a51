// SPDX-License-Identifier: MIT
// The guard filter in q31 beside the one in f32, on the teeth of the same drive.
#pragma once
#include "studies/driveline/drive_case.hpp"

namespace sixdeg {

struct Beside {
    int teeth = 0;
    int other_location = 0;  ///< Teeth at which the two say another location,
    int other_health = 0;    ///< or another health.
    double twist_apart_rms_rad = 0, twist_apart_most_rad = 0; ///< Over teeth at which neither is invalid.
    DriveFigures f32, q31;   ///< Each against the truth.
};

Beside fixed_beside(DriveCase drive);

} // namespace sixdeg
