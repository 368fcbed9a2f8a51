// SPDX-License-Identifier: MIT
// Least squares over cycles: what all cycles share (the unknowns of a gas torque, and where each tooth stands) beside what each has of its
// own (start, energy, drag), by Gauss and Newton with robust weights.
//
// The deviations come from four things: the scatter of single teeth, what is known beforehand, an unexplained torque of the cycle's first
// harmonics, fitted with the rest and as large as what is left without it makes it likely, so that an engine that does not obey the
// equations gets wide intervals, and what repeats from cycle to cycle all the same, added as a variance: with m that repeating error of
// the teeth of a cycle its effect on the shared numbers is G sum(X') m, G the inverse of the normal matrix; it does not shrink with more
// cycles.
#pragma once
#include "identify/gas_torque.hpp"

namespace sixdeg {

/// Load and friction together over a stretch of about one speed.
struct DragFound {
    double rpm;
    bool motored;
    std::vector<TimeWindow> cycles; ///< When each of them ran.
    double over_inertia, over_inertia_sd; ///< rad/s2: over J0.
    Eigen::VectorXd slope;                ///< Of over_inertia, over the unknowns.
};

struct MotionFit {
    Eigen::VectorXd values;      ///< Of the unknowns.
    Eigen::MatrixXd covariance;  ///< Of the unknowns.
    Eigen::VectorXd pattern_rad; ///< By position of the wheel, mean 0; 0 where there is no tooth.
    Eigen::VectorXd pattern_sd;  ///< The same; 0 where there is no tooth.
    std::vector<DragFound> drag; ///< Firing ones first, then by speed.
    double scatter_rad;          ///< Of a single tooth.
    double repeating_rad;        ///< Rms of what repeats unexplained, beyond what scatter makes of it.
    double unexplained_share;    ///< Of the gas torque's rms: a torque of low orders that is needed and not explained.
    std::vector<Eigen::VectorXd> grid_s; ///< Of each cycle.
    std::size_t disturbed; ///< Cycles left out, since something else acted on them.
    bool converged;

    double sd(int unknown) const { return std::sqrt(covariance(unknown, unknown)); }
};

/// At least one cycle.
MotionFit fit_motion(const EngineFile &engine, const GasTorque &gas, const std::vector<WholeCycle> &cycles);

} // namespace sixdeg
