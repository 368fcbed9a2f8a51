// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "linalg/linalg.hpp"

namespace sixdeg::linalg {

MatrixXd solve(const MatrixXd &a, const MatrixXd &b) { return a.partialPivLu().solve(b); }

MatrixXd solve_symmetric(const MatrixXd &a, const MatrixXd &b) { return a.ldlt().solve(b); }

MatrixXd least_squares(const MatrixXd &a, const MatrixXd &b) { return a.colPivHouseholderQr().solve(b); }

MatrixXd upper_triangle(const MatrixXd &a) {
    return Eigen::HouseholderQR<MatrixXd>(a).matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

MatrixXd inverse_of_triangle(const MatrixXd &r) {
    return r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(r.rows(), r.cols()));
}

VectorXd singular_values(const MatrixXd &a) {
    if (a.cols() == 0) return {};
    // The SVD of the small triangle of a tall matrix is that of the matrix, and much cheaper.
    return (a.rows() > a.cols() ? upper_triangle(a) : a).jacobiSvd().singularValues();
}

} // namespace sixdeg::linalg
