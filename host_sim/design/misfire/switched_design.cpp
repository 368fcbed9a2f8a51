// SPDX-License-Identifier: MIT
#include "design/misfire/switched_design.hpp"

#include <cmath>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

/// x' = A x + b (u + w y) with u and y constant over the step, from the exponential of [[A, b], [0, 0]].
sd_plant_step_t exact_step(const Eigen::Matrix2d &a, double output_weight, double period_s, double tick_hz) {
    Eigen::Matrix3d augmented = Eigen::Matrix3d::Zero();
    augmented.topLeftCorner<2, 2>() = a;
    augmented(1, 2) = 1;
    const Eigen::Matrix3d step = linalg::exponential(augmented * period_s) - Eigen::Matrix3d::Identity();
    sd_plant_step_t out{};
    out.period_ticks = std::uint32_t(std::lround(period_s * tick_hz));
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) out.increment[i][j] = float(step(i, j));
        out.from_input[i] = float(step(i, 2));
        out.from_output[i] = float(step(i, 2) * output_weight);
    }
    return out;
}

} // namespace

sd_plant_step_t folsmo_step(const CrankModel &model, double luenberger_per_s2, double period_s, double tick_hz) {
    Eigen::Matrix2d a;
    a << 0, 1, -(model.k1_per_s2 + luenberger_per_s2), -model.k2_per_s;
    return exact_step(a, luenberger_per_s2, period_s, tick_hz);
}

sd_plant_step_t plant_step(const CrankModel &model, double period_s, double tick_hz) {
    return folsmo_step(model, 0, period_s, tick_hz);
}

sd_plant_step_t roo_step(const CrankModel &model, double gain_per_s, double period_s, double tick_hz) {
    const double rate = model.k2_per_s + gain_per_s;
    Eigen::Matrix2d a; // x1 stays 0
    a << 0, 0, 0, -rate;
    return exact_step(a, -(model.k1_per_s2 + gain_per_s * rate), period_s, tick_hz);
}

} // namespace sixdeg
