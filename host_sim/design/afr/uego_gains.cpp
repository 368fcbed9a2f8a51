// SPDX-License-Identifier: MIT
#include "design/afr/uego_gains.hpp"

#include <Eigen/Core>
#include <cmath>

namespace sixdeg {

// State: mean, then (p, q) of each harmonic turning by its own angle a position, s2, s1. The block's c_k E_k
// is p + j q, so a gain (g, h) on (p, q) is G = g + j h.
sd_uego_gains_t uego_gains(const UegoDesign &d) {
    const int n = 2 * d.harmonics + 1, s2 = n, s1 = n + 1, size = n + 2;
    const double m2 = 1 - std::exp(-d.step_s / d.tau2_s), m1 = 1 - std::exp(-d.step_s / d.tau1_s);
    Eigen::MatrixXd f = Eigen::MatrixXd::Zero(size, size), q = Eigen::MatrixXd::Zero(size, size);
    f(0, 0) = 1;
    Eigen::RowVectorXd u = Eigen::RowVectorXd::Zero(size);
    for (int k = 1; k <= d.harmonics; ++k) {
        const double a = 2 * M_PI * k / d.cycle_positions;
        f.block<2, 2>(2 * k - 1, 2 * k - 1) << std::cos(a), -std::sin(a), std::sin(a), std::cos(a);
    }
    u(0) = 1;
    for (int k = 1; k <= d.harmonics; ++k) u(2 * k - 1) = 1;
    const Eigen::RowVectorXd turned = u.head(n) * f.topLeftCorner(n, n);
    f.row(s2).head(n) = m2 * turned;
    f(s2, s2) = 1 - m2;
    f.row(s1) = m1 * f.row(s2);
    f(s1, s1) += 1 - m1;
    q.topLeftCorner(n, n).diagonal().setConstant(d.drift * d.drift / d.cycle_positions);
    Eigen::MatrixXd p = Eigen::MatrixXd::Identity(size, size) * 0.01;
    Eigen::VectorXd gain(size);
    for (int i = 0; i < 40 * d.cycle_positions; ++i) {
        p = f * p * f.transpose() + q;
        gain = p.col(s1) / (p(s1, s1) + d.noise * d.noise);
        p -= gain * p.row(s1);
    }
    sd_uego_gains_t gains{};
    gains.re[0] = float(gain(0));
    for (int k = 1; k <= d.harmonics; ++k) {
        gains.re[k] = float(gain(2 * k - 1));
        gains.im[k] = float(gain(2 * k));
    }
    gains.lag2 = float(gain(s2));
    gains.lag1 = float(gain(s1));
    return gains;
}

} // namespace sixdeg
