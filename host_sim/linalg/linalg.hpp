// SPDX-License-Identifier: MIT
// Eigenvalues, linear equations, matrix exponentials and Riccati equations for matrices of any size, in double precision.
//
// The only place that compiles Eigen's decompositions: include this instead of <Eigen/Dense>, <Eigen/LU> and the like, which cost
// every file that includes them 5 to 20 s. <Eigen/Core>, for the matrices themselves, comes with it. Sizes are the caller's to
// get right; a debug build asserts them. Nothing here throws, and NaN in gives NaN out.
#pragma once
#include <Eigen/Core>

namespace sixdeg::linalg {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Eigenvalues of a square matrix, each as often as it occurs, in no particular order.
VectorXcd eigenvalues(const MatrixXd &a);
/// Magnitude of the largest of them: below 1, x <- A x dies out.
double spectral_radius(const MatrixXd &a);

/// Vibrations of M x'' + K x = 0.
struct Vibrations {
    VectorXd squared_radps2; ///< Squares of the angular frequencies, ascending; of a free body near 0, maybe a little below.
    MatrixXd shapes;         ///< [coordinate][vibration], scaled so that shape' M shape is 1.
};
/// `stiffness` symmetric, `inertia` the diagonal of M, all above 0.
Vibrations vibrations(const MatrixXd &stiffness, const VectorXd &inertia);

/// X of A X = B, A square and regular (LU with partial pivoting).
MatrixXd solve(const MatrixXd &a, const MatrixXd &b);
/// The same for a symmetric A that is positive or negative semidefinite (LDL').
MatrixXd solve_symmetric(const MatrixXd &a, const MatrixXd &b);
/// X with the smallest |A X - B|, A with at least as many rows as columns (QR with column pivoting).
MatrixXd least_squares(const MatrixXd &a, const MatrixXd &b);
/// Upper triangle R of a QR decomposition, as many rows as columns: R' R = A' A. A has at least as many rows as columns.
MatrixXd upper_triangle(const MatrixXd &a);
/// Inverse of a regular upper triangle; what stands below its diagonal is not looked at.
MatrixXd inverse_of_triangle(const MatrixXd &r);
/// Singular values, descending; none for a matrix without columns.
VectorXd singular_values(const MatrixXd &a);

/// exp(A) of a square matrix.
MatrixXd exponential(const MatrixXd &a);

/// One doubling of the steady Riccati equation (B. D. O. Anderson, Int. J. Control 28, 1978). A stretch of steps takes any
/// covariance P to E + F P (I + D P)^-1 F': E what it ends with when nothing was unknown, F the error's map, D what its
/// measurements tell of the start. Two equal stretches make one of twice the length, which is written over the first. E and D
/// are symmetric, and stay so to the bit.
void double_stretch(MatrixXd &e, MatrixXd &d, MatrixXd &f);

} // namespace sixdeg::linalg
