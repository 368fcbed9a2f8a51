// SPDX-License-Identifier: MIT
// What a set of sensors is worth where noise matters: the steady standard deviation of a Kalman filter's states.
#pragma once
#include "observability/linear_point.hpp"

namespace sixdeg {

/// Everything the steady filter of one set is made of; kept so that a test can put the result back into the Riccati
/// equation. Discrete time, scaled states.
struct SteadyFilter {
    Eigen::MatrixXd phi, c, q, r;
    Eigen::MatrixXd predicted; ///< Covariance just before a sample.
    Eigen::MatrixXd updated;   ///< Covariance just after it.
};

SteadyFilter steady_filter(const SensorModel &model, const NumericModel &numeric, const LinearPoint &point, SensorSet set);

/// Standard deviation of each target state after a sample, SI units.
std::vector<double> steady_sigma(const SensorModel &model, const NumericModel &numeric, const LinearPoint &point,
                                 SensorSet set, const std::vector<int> &targets);

} // namespace sixdeg
