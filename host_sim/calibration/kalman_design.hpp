// SPDX-License-Identifier: MIT
// Gains of the periodic Kalman filter on tooth times, and what they make of timing errors.
//
// Everything is normalised at one speed w: angles in rad, energies and torques over J_mean w^2. From tooth k - 1 to
// k, with pitch d, j = J_interval / J_mean and the interval's mean and moment of the basis (sd_kalman.h),
//     phi += -(d/j) (eps + d moment . x),   eps += d mean . x,   z = phi + v
// and each firing's coefficient gets new variance shortly before its TDC: nobody knows how the next one will burn.
#pragma once
#include <Eigen/Core>
#include <vector>

namespace sixdeg {

struct ToothModel {
    int positions = 60;                 ///< A revolution, N.
    std::vector<bool> present;          ///< [N]
    std::vector<double> inertia_ratio;  ///< [N] J_interval that ends at position k, over J_mean.
    Eigen::MatrixXd mean, moment;       ///< [2 N][m] of the basis; column 0 is the constant torque.
    std::vector<int> inject_at, read_at; ///< Cycle position for coefficients 1, 2 ...; empty: no firings.

    int cycle() const { return 2 * positions; }
    int states() const { return int(mean.cols()) + 2; }
    double pitch() const;
};

/// Standard deviations, normalised.
struct ToothNoise {
    double edge_rad;      ///< Of each tooth edge.
    double constant_walk; ///< Of the constant torque's step from tooth to tooth.
    double firing_change; ///< Of each firing's coefficient from one cycle to the next.
    double basis_walk;    ///< Of the other coefficients' step from tooth to tooth (Fourier basis).
};

struct PeriodicGains {
    Eigen::MatrixXd gain;  ///< [2 N][m + 2]; zero where no tooth is.
    double radius;         ///< Largest eigenvalue, by magnitude, of the error's map over a cycle.
    double innovation;     ///< Its rms over edge_rad.
    /// Of a firing less the mean of all firings of its cycle, rms over the cylinders, per rad of timing error: one
    /// firing, errors new at each edge; mean of `mean_cycles`, the same; the same, errors that stay with each tooth.
    double single_sd = 0, mean_sd = 0, pattern_sd = 0;
    /// Of a firing itself, rms over the firings, from the constant torque's walk; normalised.
    double load_sd = 0;
};

/// Iterates the Riccati recursion over whole cycles until the gains repeat.
PeriodicGains design_gains(const ToothModel &model, const ToothNoise &noise, int mean_cycles);

/// Largest eigenvalue, by magnitude, of the error's map over a cycle for any gains.
double cycle_radius(const ToothModel &model, const Eigen::MatrixXd &gain);

/// Step of the error's prediction into cycle position k, rows of `error` (any number of columns).
void predict_error(const ToothModel &model, int k, Eigen::Ref<Eigen::MatrixXd> error);

} // namespace sixdeg
