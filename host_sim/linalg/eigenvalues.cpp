// SPDX-License-Identifier: MIT
#include <Eigen/Eigenvalues>

#include "linalg/linalg.hpp"

namespace sixdeg::linalg {

VectorXcd eigenvalues(const MatrixXd &a) { return a.eigenvalues(); }

double spectral_radius(const MatrixXd &a) { return eigenvalues(a).cwiseAbs().maxCoeff(); }

Vibrations vibrations(const MatrixXd &stiffness, const VectorXd &inertia) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(stiffness, MatrixXd(inertia.asDiagonal()));
    return {solver.eigenvalues(), solver.eigenvectors()};
}

} // namespace sixdeg::linalg
