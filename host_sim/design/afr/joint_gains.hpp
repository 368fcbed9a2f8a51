// SPDX-License-Identifier: MIT
// Gains by wheel position for the joint filter of firmware/afr where it is not to find them itself.
#pragma once
#include <array>
#include <vector>

namespace sixdeg {

/// Gas as the sensor meets it within one position, any unit of mass.
struct JointPosition {
    double mass = 0;                ///< In the manifold, after the position.
    std::array<double, 8> inflow{}; ///< Of each cylinder, in firing order.
};

struct JointDesign {
    std::vector<JointPosition> cycle;
    int cylinders = 0;
    double tau1_s = 0, tau2_s = 0, step_s = 0;
    double noise = 0; ///< rms of lambda a position.
    double drift = 0; ///< Of a cylinder in one cycle, of lambda.
};

/// K of each position in the order x, a_i, s2, s1, from the periodic solution of the Riccati equation.
std::vector<std::vector<float>> joint_gains(const JointDesign &design);

} // namespace sixdeg
