// SPDX-License-Identifier: MIT
#include <unsupported/Eigen/MatrixFunctions>

#include "linalg/linalg.hpp"

namespace sixdeg::linalg {

MatrixXd exponential(const MatrixXd &a) { return a.exp(); }

} // namespace sixdeg::linalg
