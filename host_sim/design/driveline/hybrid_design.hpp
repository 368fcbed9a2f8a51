// SPDX-License-Identifier: MIT
// Gains of document 003's hybrid observer (firmware/driveline/sd_driveline_hybrid.h) from a driveline, and what its propositions say
// of them, as corrected in docs/theory/driveline.md.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "common/driveline.hpp"
#include "sd_driveline_hybrid.h"

namespace sixdeg {

/// A location about an equilibrium: x' = A x + E + B u + D d, y = C x, x = (torsion, crank speed, wheel speed), y in rpm, d the road's
/// resistance at the wheels.
struct LocationModel {
    Eigen::Matrix3d a;
    Eigen::Vector3d e, b, d;
    Eigen::RowVector3d c;
};
LocationModel location_model(const Driveline &driveline, double ratio, double equilibrium_rad, Location location);

/// L such that A - L C has these eigenvalues (Ackermann). The pair must be observable.
Eigen::Vector3d observer_gain(const LocationModel &model, const Eigen::Vector3d &poles);

struct HybridBelief {
    double equilibrium_rad = 0.025;
    Eigen::Vector3d residual_poles{-60, -70, -80}, observer_poles{-12, -15, -18};
    double threshold_rpm = 0.02, period_s = 1e-3, hold_s = 0.06, calm_s = 0.01, settle_s = 0.5;
    bool at_rest = false; ///< The equilibrium is that of rest: equilibrium_rad is 0, and speeds and torques are plain ones.
};
/// Tables for steps of period_s: u held over a step, y straight.
sd_driveline_bank_t hybrid_tables(const Driveline &driveline, double ratio, const HybridBelief &belief);

/// max |X^-1| |X| over the eigenvectors' matrix X with columns of length 1, 2-norms: the k(A) of the document.
double eigenvector_condition(const Eigen::Matrix3d &a);

/// Proposition 3.1.1: the right location's residual is below the threshold within delay_s where the largest real part is at most `needed`.
struct ResidualSpeed {
    double abscissa, needed, condition;
    bool holds() const { return abscissa <= needed; }
};
ResidualSpeed residual_speed(const Eigen::Matrix3d &h, const Eigen::RowVector3d &c, double delay_s, double first_error, double threshold);

/// Proposition 3.1.3 asks whether the wrong location's residual can be steered to zero for ever. Its condition, an invertible
/// C_ji B_i + C_j B_ij, never holds for the driveline, where locations share B and C; the input then reaches the residual later:
/// through the first of C_j H_j^p M_ji A_i^q B that is not 0, p + q + 1 further derivatives on. `order` counts them, 1 for the document's
/// condition; nothing: no input can be seen in it, nor hide it. Where there is an order, some input hides a wrong location.
std::optional<int> hiding_order(const LocationModel &real, const LocationModel &believed, const Eigen::Vector3d &gain);

/// Proposition 3.3.1: the state's error ends within `bound`. Steps of the proof that the document drops are in: the factor n k, and E.
struct ErrorBound {
    double contraction; ///< n k exp(a D): must be below 1.
    std::optional<double> bound;
};
/// dwell_s: D, the time between two changes; delay_s: how late they are found; drive: V, the largest |v|, E included.
ErrorBound error_bound(const Eigen::Matrix3d &f, double dwell_s, double delay_s, double drive);
/// The document's own M0 = n k V delay / (1 - exp(a D)), for comparison.
double printed_bound(const Eigen::Matrix3d &f, double dwell_s, double delay_s, double drive);

/// Rigorous in its place: one P with F_i' P + P F_i <= -2 a P for all F_i. `push` is the direction of v, largest_nm its size; the torsion's
/// error ends within the returned, rad. Nothing where no such P was found. P is sought from `decay` as the Lyapunov matrix of a mix
/// of the F_i, refined by a search.
std::optional<double> common_bound_rad(const std::vector<Eigen::Matrix3d> &f, const Eigen::Vector3d &push, double largest_nm, double decay,
                                       double dwell_s, double delay_s);

} // namespace sixdeg
