// SPDX-License-Identifier: MIT
// What a set of sensors is worth where noise matters: the steady standard deviation of a Kalman filter's
// states.
#pragma once
#include "studies/sensor_sets/linear_point.hpp"

namespace sixdeg {

/// Everything the steady filter of one set is made of; kept so that a test can put the result back into the
/// Riccati equation. Discrete time, scaled states.
struct SteadyFilter {
    Eigen::MatrixXd phi, c, q, r;
    Eigen::MatrixXd predicted; ///< Covariance just before a sample.
    Eigen::MatrixXd updated;   ///< Covariance just after it.
    Eigen::VectorXd growth; ///< Of each variance in the last doubling, relative; near 0 where it is steady.
};

SteadyFilter steady_filter(const SensorModel &model, const NumericModel &numeric, const LinearPoint &point,
                           SensorSet set);

/// Standard deviation of each target state after a sample, SI units; infinite where no steady one exists.
std::vector<double> steady_sigma(const SensorModel &model, const NumericModel &numeric,
                                 const LinearPoint &point, SensorSet set, const std::vector<int> &targets);

} // namespace sixdeg
