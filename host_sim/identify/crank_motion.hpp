// SPDX-License-Identifier: MIT
// When the teeth of a cycle pass, by the kinetic energy of the crank, and what each unknown changes about it.
//
// With b the crank angle as the engine file has the wheel, and everything over J0:
//   e(b) = e0 + integral of (T_gas(b) / J0 - d),   t(b) = t0 + integral of sqrt(j(b) / (2 e(b)))
// j = J / J0 = 1 + m r(b) / J0 with r the sum of the squares of the pistons' x'. An unknown that adds the torque T_q and the inertia j_q
// makes a tooth late, as an angle, by
//   sqrt(2 e / j) integral of sqrt(j / (2 e)) (j_q / (2 j) - C_q / (2 e)),   C_q = integral of T_q / J0.
#pragma once
#include <Eigen/Core>

#include "identify/crank_record.hpp"

namespace sixdeg {

/// Angles at which torque is known: from -360 to 360 deg, both ends.
constexpr double kGridDeg = 0.5;
constexpr int kGridPoints = 1441;
inline double grid_deg(int i) { return -360 + kGridDeg * i; }

/// What is a cycle's own.
struct CycleStart {
    double t_s;        ///< When the grid begins.
    double energy;     ///< e0, rad2/s2.
    double drag_radps2; ///< d: load and friction over J0.
};

/// Of one cycle, over the grid, for the present values of the unknowns.
struct CycleTorque {
    Eigen::VectorXd gas_over_j;   ///< rad/s2
    Eigen::VectorXd ripple;       ///< j
    Eigen::MatrixXd torque_slope; ///< [grid][unknown], of gas_over_j.
    Eigen::MatrixXd ripple_slope; ///< [grid][unknown], of j.
};

/// How late the teeth are, and what changes that.
struct CycleLateness {
    Eigen::VectorXd late_rad;      ///< Behind the prediction.
    Eigen::MatrixXd over_start;    ///< [tooth][3], over t0 x mean speed (rad), relative energy, and d over the mean of e in a cycle.
    Eigen::MatrixXd over_unknowns; ///< [tooth][unknown]
    Eigen::VectorXd time_s;        ///< Predicted, over the grid.
    double mean_energy;            ///< What the last two columns of over_start are scaled by.
};

CycleLateness lateness(const WholeCycle &cycle, const CycleTorque &torque, const CycleStart &start);
/// Moves the start by the fit's answer for the columns of over_start.
void move(CycleStart &start, const Eigen::Vector3d &by, const CycleLateness &scales, double speed_radps);
/// Drag, rad/s2, of a fit's answer 1 for the third column.
double drag_unit(const CycleLateness &scales);
/// When the crank passed the angles of the grid, straight from tooth to tooth.
Eigen::VectorXd grid_times(const WholeCycle &cycle);
/// The same by a prediction, which tells how the speed bends between two teeth, above all in the mark; straight is only what teeth are
/// late against it. `pattern_rad`, by position, is by how much each stands further on.
Eigen::VectorXd grid_times(const WholeCycle &cycle, const Eigen::VectorXd &predicted_s, const Eigen::VectorXd &pattern_rad);
/// A start to begin with: steady speed, no drag.
CycleStart steady_start(const WholeCycle &cycle);

} // namespace sixdeg
