// SPDX-License-Identifier: MIT
#include "design/driveline/guard_design.hpp"

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using linalg::MatrixXd;

constexpr double kPi = 3.14159265358979323846;
constexpr double kShortestS = 1.220703125e-4; // 2^-13: 6 deg at 8192 rpm
constexpr int kDoublings = 30;                // 1e9 teeth

/// States of the filter; the wheels' phase stands last, and only where wheels have teeth.
MatrixXd rates(const Driveline &d, double ratio, double stiffness, int states) {
    MatrixXd a = MatrixXd::Zero(states, states);
    const double je = d.engine_inertia_kgm2, jv = d.vehicle_inertia_kgm2;
    a(SD_DRIVELINE_PHASE, SD_DRIVELINE_SPEED) = 1;
    a(SD_DRIVELINE_SPEED, SD_DRIVELINE_SPEED) = -(d.engine_viscous_nms + ratio * ratio * d.damping_nms) / je;
    a(SD_DRIVELINE_SPEED, SD_DRIVELINE_TWIST) = -ratio * stiffness / je;
    a(SD_DRIVELINE_SPEED, SD_DRIVELINE_WHEEL) = ratio * d.damping_nms / je;
    a(SD_DRIVELINE_SPEED, SD_DRIVELINE_BIAS) = 1 / je;
    a(SD_DRIVELINE_TWIST, SD_DRIVELINE_SPEED) = ratio;
    a(SD_DRIVELINE_TWIST, SD_DRIVELINE_WHEEL) = -1;
    a(SD_DRIVELINE_WHEEL, SD_DRIVELINE_SPEED) = ratio * d.damping_nms / jv;
    a(SD_DRIVELINE_WHEEL, SD_DRIVELINE_TWIST) = stiffness / jv;
    a(SD_DRIVELINE_WHEEL, SD_DRIVELINE_WHEEL) = -d.damping_nms / jv;
    if (states > SD_DRIVELINE_WHEEL_PHASE) a(SD_DRIVELINE_WHEEL_PHASE, SD_DRIVELINE_WHEEL) = 1;
    return a;
}

struct Gains {
    MatrixXd k; ///< [state][0: tooth, 1: edge of the wheels].
};

/// The steady filter's, for steps of h seconds. An edge of the wheels every m teeth counts as one of m times the variance at each tooth,
/// and corrects m times as much.
Gains steady(const Driveline &d, const GuardBelief &b, double ratio, double stiffness, double h, double teeth_per_wheel_tooth) {
    const bool wheels = b.wheel_jitter_rad > 0;
    const int n = wheels ? 6 : 5;
    const double je = d.engine_inertia_kgm2;
    const MatrixXd a = rates(d, ratio, stiffness, n);
    MatrixXd q = MatrixXd::Zero(n, n);
    q(SD_DRIVELINE_SPEED, SD_DRIVELINE_SPEED) = h * std::pow(b.torque_noise_nm / je, 2);
    q(SD_DRIVELINE_TWIST, SD_DRIVELINE_TWIST) = h * std::pow(b.twist_walk_rad, 2);
    q(SD_DRIVELINE_WHEEL, SD_DRIVELINE_WHEEL) = h * std::pow(b.road_walk_radps, 2);
    q(SD_DRIVELINE_BIAS, SD_DRIVELINE_BIAS) = h * std::pow(b.bias_walk_nm, 2);
    const int rows = wheels ? 2 : 1;
    MatrixXd c = MatrixXd::Zero(rows, n), r = MatrixXd::Zero(rows, rows);
    c(0, SD_DRIVELINE_PHASE) = 1;
    r(0, 0) = std::pow(b.jitter_rad, 2);
    if (wheels) {
        c(1, SD_DRIVELINE_WHEEL_PHASE) = 1;
        r(1, 1) = std::pow(b.wheel_jitter_rad, 2) * teeth_per_wheel_tooth;
    }
    MatrixXd e = q, f = linalg::exponential(a * h), g = c.transpose() * linalg::solve(r, c);
    for (int i = 0; i < kDoublings; ++i) linalg::double_stretch(e, g, f);
    const MatrixXd s = c * e * c.transpose() + r;
    MatrixXd k = linalg::solve(s.transpose(), (e * c.transpose()).transpose()).transpose();
    if (wheels) k.col(1) *= teeth_per_wheel_tooth;
    return {k};
}

sd_driveline_gear_t gear_tables(const Driveline &d, const GuardBelief &b, double ratio, int positions) {
    sd_driveline_gear_t gear{};
    gear.ratio = float(ratio);
    const double teeth = positions / (ratio * b.wheel_positions);
    for (int stiff = 0; stiff < 2; ++stiff) {
        for (int octave = 0; octave < SD_DRIVELINE_OCTAVES; ++octave) {
            const double h = kShortestS * std::pow(2.0, octave);
            const double stiffness = stiff ? d.stiff_nmprad : d.soft_nmprad;
            const Gains gains = steady(d, b, ratio, stiffness, h, teeth), start = steady(d, b.starting(), ratio, stiffness, h, teeth);
            for (int i = 0; i < gains.k.rows(); ++i) {
                gear.tooth[stiff][octave].of[i] = float(gains.k(i, 0));
                gear.start[stiff][octave].of[i] = float(start.k(i, 0));
                if (gains.k.cols() > 1) gear.wheel[stiff][octave].of[i] = float(gains.k(i, 1));
            }
        }
    }
    return gear;
}

} // namespace

sd_driveline_tables_t guard_tables(const Driveline &d, const GuardBelief &b, int positions, double tick_s, sd_driveline_guard_by_t guard) {
    sd_driveline_tables_t t{};
    t.tick_s = float(tick_s);
    t.pitch_rad = float(2 * kPi / positions);
    t.wheel_pitch_rad = b.wheel_jitter_rad > 0 ? float(2 * kPi / b.wheel_positions) : 0;
    t.shortest_s = float(kShortestS);
    t.per_inertia = float(1 / d.engine_inertia_kgm2);
    t.viscous_nms = float(d.engine_viscous_nms);
    t.per_vehicle = float(1 / d.vehicle_inertia_kgm2);
    t.soft_nmprad = float(d.soft_nmprad);
    t.stiff_nmprad = float(d.stiff_nmprad);
    t.damping_nms = float(d.damping_nms);
    t.kink_rad = float(d.kink_rad);
    t.rolling_nm = float(d.rolling_nm);
    t.drag_nms2 = float(d.drag_nms2);
    t.reject_rad = 0.035f;
    t.per_reject = 1 / t.reject_rad;
    t.doubt_rad = float(b.doubt_rad);
    t.settle_s = 0.5f;
    t.moving_radps = 0.05f;
    t.moving_hold_s = 0.25f;
    t.guard = std::uint8_t(guard);
    t.gears = std::uint8_t(std::min<std::size_t>(d.ratios.size(), SD_DRIVELINE_GEARS_MAX));
    for (std::size_t g = 0; g < t.gears; ++g) t.gear[g] = gear_tables(d, b, d.ratios[g], positions);
    return t;
}

} // namespace sixdeg
