// SPDX-License-Identifier: MIT
#include "design/misfire/switched_design.hpp"

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

/// x' = A x + b (u + w y) with u and y constant over the step, from the exponential of [[A, b], [0, 0]].
PlantStep exact_step(const Eigen::Matrix2d &a, double output_weight, double period, double output_gain = 0) {
    Eigen::Matrix3d augmented = Eigen::Matrix3d::Zero();
    augmented.topLeftCorner<2, 2>() = a;
    augmented(1, 2) = 1;
    const Eigen::Matrix3d step = linalg::exponential(augmented * period) - Eigen::Matrix3d::Identity();
    PlantStep out{};
    out.period = period;
    out.output_gain = output_gain;
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) out.increment[i][j] = step(i, j);
        out.from_input[i] = step(i, 2);
        out.from_output[i] = step(i, 2) * output_weight;
    }
    return out;
}

} // namespace

PlantStep folsmo_step(const CrankModel &model, double luenberger_per_s2, double period) {
    Eigen::Matrix2d a;
    a << 0, 1, -(model.k1_per_s2 + luenberger_per_s2), -model.k2_per_s;
    return exact_step(a, luenberger_per_s2, period);
}

PlantStep plant_step(const CrankModel &model, double period) { return folsmo_step(model, 0, period); }

PlantStep roo_step(const CrankModel &model, double gain_per_s, double period) {
    const double rate = model.k2_per_s + gain_per_s;
    Eigen::Matrix2d a; // x1 stays 0
    a << 0, 0, 0, -rate;
    return exact_step(a, -(model.k1_per_s2 + gain_per_s * rate), period, gain_per_s);
}

} // namespace sixdeg
