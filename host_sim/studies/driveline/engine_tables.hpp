// SPDX-License-Identifier: MIT
// Tables of the driveline behind a simulated engine, and how a drive's figures are printed.
#pragma once
#include <string>

#include "studies/driveline/drive_score.hpp"

namespace sixdeg {

void print_drive_header(const char *title);
void print_drive(const std::string &name, const DriveFigures &figures);

void print_own_torque(double seconds, unsigned seed);
/// Of `seconds` at 1000 rpm; of at most 300 s elsewhere.
void print_shuffle_misfires(double seconds, unsigned seed);

} // namespace sixdeg
