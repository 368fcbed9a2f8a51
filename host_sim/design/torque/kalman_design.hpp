// SPDX-License-Identifier: MIT
// Gains of the periodic Kalman filter on tooth times, and what they make of timing errors.
//
// Everything is normalised at one speed w: angles in rad, energies and torques over J_mean w^2. From tooth k - 1 to
// k, with pitch d, j = J_interval / J_mean and the interval's mean and moment of the basis (sd_kalman.h),
//     phi += -(d/j) (eps + d moment . x),   eps += d mean . x,   z = phi + v
// A mode's twist q of the wheel, and its rate over its frequency v, add to what is seen (z = phi - sum of q + v); with
// A = [0 1; -1 -2 damping] and the twist F that the torques hold, (q - F, v) <- exp(A w_m d / w) (q - F, v).
// And each firing's coefficient gets new variance shortly before its TDC: nobody knows how the next one will burn.
#pragma once
#include <Eigen/Core>
#include <vector>

extern "C" {
#include "sd_kalman.h"
}

namespace sixdeg {

/// Bounded by the firmware's largest filter, so that no step of a recursion takes from the heap.
constexpr int kMostStates = 2 + SD_KALMAN_COEFFICIENTS_MAX + 2 * SD_KALMAN_MODES_MAX;
using StateMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostStates, kMostStates>;
using StateRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostStates>;

/// A mode of the crank at one speed, a pitch long.
struct ToothMode {
    double a, b, damping;            ///< exp(A w_m d / w) = a I + b A.
    Eigen::RowVectorXd compliance;   ///< [m] twist of the wheel that the torques of an interval hold, normalised.
};

/// From the angle of the undamped vibration over a pitch.
ToothMode tooth_mode(double turn_rad, double damping, const Eigen::RowVectorXd &compliance);

struct ToothModel {
    int positions = 60;                 ///< A revolution, N.
    std::vector<bool> present;          ///< [N]
    std::vector<double> inertia_ratio;  ///< [N] J_interval that ends at position k, over J_mean.
    Eigen::MatrixXd mean, moment;       ///< [2 N][m] of the basis; column 0 is the constant torque.
    std::vector<ToothMode> modes;
    std::vector<int> inject_at, read_at; ///< Cycle position for coefficients 1, 2 ...; empty: no firings.

    int cycle() const { return 2 * positions; }
    int torques() const { return int(mean.cols()); }
    int mode_at(std::size_t i) const { return 2 + torques() + 2 * int(i); } ///< Index of its twist.
    int states() const { return mode_at(modes.size()); } ///< phi, eps, x, then q and v of each mode.
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
    Eigen::MatrixXd gain;  ///< [2 N][states]; zero where no tooth is.
    double radius;         ///< Largest eigenvalue, by magnitude, of the error's map over a cycle.
    double innovation;     ///< Its rms over edge_rad.
    /// Of a firing less the mean of all firings of its cycle (of one cylinder, of itself), rms over the cylinders, per rad of timing error:
    /// one firing, errors new at each edge; mean of `mean_cycles`, the same; the same, errors that stay with each tooth.
    double single_sd = 0, mean_sd = 0, pattern_sd = 0;
    /// Of a firing itself, rms over the firings, from the constant torque's walk; normalised.
    double load_sd = 0;
};

/// Iterates the Riccati recursion over whole cycles until the gains repeat.
PeriodicGains design_gains(const ToothModel &model, const ToothNoise &noise, int mean_cycles);

/// Largest eigenvalue, by magnitude, of the error's map over a cycle for any gains.
double cycle_radius(const ToothModel &model, const Eigen::MatrixXd &gain);

/// What is read while torques that the model lacks act in every cycle alike, one of each cylinder at a time; mean and moment
/// over each interval, [2 N][cylinder]. [coefficient but the constant][cylinder]: firings where they are read, others at the cycle's end.
Eigen::MatrixXd steady_reading(const ToothModel &model, const Eigen::MatrixXd &gain, const Eigen::MatrixXd &mean,
                               const Eigen::MatrixXd &moment);

/// What of the state a tooth edge shows.
StateRow seen(const ToothModel &model);

/// Step of the error's prediction into cycle position k, rows of `error` (any number of columns up to kMostStates).
void predict_error(const ToothModel &model, int k, StateMatrix &error);

} // namespace sixdeg
