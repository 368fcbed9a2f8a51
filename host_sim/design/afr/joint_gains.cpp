// SPDX-License-Identifier: MIT
#include "design/afr/joint_gains.hpp"

#include <Eigen/Core>
#include <cmath>

namespace sixdeg {
namespace {

/// One position of sd_afr_joint.h as a matrix; state x, a_i, s2, s1.
Eigen::MatrixXd transition(const JointDesign &d, const JointPosition &p) {
    const int n = d.cylinders, s2 = n + 1, s1 = n + 2;
    const double m2 = 1 - std::exp(-d.step_s / d.tau2_s), m1 = 1 - std::exp(-d.step_s / d.tau1_s);
    Eigen::MatrixXd f = Eigen::MatrixXd::Identity(n + 3, n + 3);
    double inflow = 0;
    for (int i = 0; i < n; ++i) inflow += p.inflow[std::size_t(i)];
    const double mass = std::fmax(p.mass, inflow);
    f(0, 0) = (mass - inflow) / mass;
    for (int i = 0; i < n; ++i) f(0, 1 + i) = p.inflow[std::size_t(i)] / mass;
    f.row(s2) = m2 * f.row(0);
    f(s2, s2) += 1 - m2;
    f.row(s1) = m1 * f.row(s2);
    f(s1, s1) += 1 - m1;
    return f;
}

} // namespace

std::vector<std::vector<float>> joint_gains(const JointDesign &d) {
    constexpr int kCycles = 200; // until the covariance repeats itself
    const int n = d.cylinders, size = n + 3, positions = int(d.cycle.size());
    std::vector<Eigen::MatrixXd> f;
    for (const JointPosition &p : d.cycle) f.push_back(transition(d, p));
    std::vector<std::vector<float>> gains(d.cycle.size());
    Eigen::MatrixXd cov = Eigen::MatrixXd::Identity(size, size) * 0.01;
    for (int k = 0; k < kCycles * positions; ++k) {
        const auto at = std::size_t(k % positions), before = std::size_t((k + positions - 1) % positions);
        for (std::size_t i = 0; i < std::size_t(n); ++i)
            if (d.cycle[at].inflow[i] > 0 && !(d.cycle[before].inflow[i] > 0))
                cov(Eigen::Index(i) + 1, Eigen::Index(i) + 1) += d.drift * d.drift;
        cov = (f[at] * cov * f[at].transpose()).eval();
        const Eigen::VectorXd gain = cov.col(size - 1) / (cov(size - 1, size - 1) + d.noise * d.noise);
        cov = (cov - gain * cov.row(size - 1)).eval();
        if (k >= (kCycles - 1) * positions) gains[at].assign(gain.data(), gain.data() + size);
    }
    return gains;
}

} // namespace sixdeg
