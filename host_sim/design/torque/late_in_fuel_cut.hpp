// SPDX-License-Identifier: MIT
// What a torque that is not in the calibration does to the teeth in fuel cut, as the learning of the tooth pattern reads it (sd_pattern.h).
#pragma once
#include <vector>

#include "design/torque/kalman_tables.hpp"

namespace sixdeg {

/// Lateness of each tooth of a revolution at SD_PATTERN_REFERENCE_RADPS, rad for the torque's unit in Nm; 0 where there is no tooth.
/// Constant torque and speed are not known there, so it is the mean of both revolutions, with a trend a1 k + a2 k^2 found from their
/// difference and the mean of all teeth taken out.
std::vector<double> late_in_fuel_cut(const EngineFile &engine, const TorqueOverAngle &torque);

} // namespace sixdeg
