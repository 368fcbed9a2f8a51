// SPDX-License-Identifier: MIT
// What a driver does with a driveline: tip-in, tip-out, a change of gear, the clutch, crawling.
#pragma once
#include <functional>
#include <vector>

#include "studies/driveline/drive_case.hpp"

namespace sixdeg {

struct Manoeuvre {
    const char *name;
    double speed_rpm;  ///< At the start, in first gear of the ratios below.
    double shaft_nm;   ///< At the wheels, at the start.
    double counts_from_s, duration_s;
    std::vector<double> ratios;
    std::function<DriverInput(double time_s)> driver;
};
const std::vector<Manoeuvre> &manoeuvres();
DriveFigures run_manoeuvre(const Manoeuvre &manoeuvre, DriveCase drive);

} // namespace sixdeg
