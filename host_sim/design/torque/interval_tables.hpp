// SPDX-License-Identifier: MIT
// A torque between two teeth, as the filters on tooth times know it.
#pragma once
#include "design/torque/kalman_tables.hpp"

namespace sixdeg {

/// A torque over the interval that ends at a tooth, N m: its mean; its mean weighed by the share of the interval that is still to come;
/// and its value at the tooth.
struct Interval {
    double mean = 0, moment = 0, point = 0;
};

/// Where position k of the cycle (any real number) stands, rad of crank.
double tooth_angle(const EngineFile &engine, double k);

/// Simpson's rule over the interval that ends at tooth k, fine enough for the kink where combustion begins.
Interval over_interval(const EngineFile &engine, const TorqueOverAngle &torque, int k);

} // namespace sixdeg
