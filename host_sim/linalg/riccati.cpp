// SPDX-License-Identifier: MIT
#include <Eigen/LU>

#include "linalg/linalg.hpp"

namespace sixdeg::linalg {

void double_stretch(MatrixXd &e, MatrixXd &d, MatrixXd &f) {
    const Eigen::PartialPivLU<MatrixXd> both(MatrixXd::Identity(e.rows(), e.rows()) + e * d);
    const MatrixXd through = both.solve(f), left = both.solve(e);
    e += (f * left * f.transpose()).eval();
    d += (f.transpose() * d * through).eval();
    f = (f * through).eval();
    e = (0.5 * (e + e.transpose())).eval();
    d = (0.5 * (d + d.transpose())).eval();
}

} // namespace sixdeg::linalg
