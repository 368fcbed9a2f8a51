// SPDX-License-Identifier: MIT
#include "studies/airpath/matched_filter.hpp"

#include <Eigen/LU>
#include <cmath>

namespace sixdeg {
namespace {

constexpr double kAirNoise = 0.01, kRadpsPerRpm = M_PI / 30, kAirJpkgk = 287, kExhaustJpkgk = 286;
constexpr int kSubsteps = 2;

} // namespace

MatchedFilter::MatchedFilter(const MatchedSetup &setup, double walk_gps)
    : setup_(&setup), walk_gps_(walk_gps), model_(setup.system, setup.displaced_m3) {}

MatchedFilter::State MatchedFilter::moved(const State &x, const sd_airpath_in_f32_t &in) const {
    const AirPathSystem &s = setup_->system;
    const double per_exhaust = 1e-6 * kExhaustJpkgk * s.exhaust_k / s.exhaust_m3,
        k = model_.emptying_ps(double(in.speed_rpm) * kRadpsPerRpm);
    const MeanValueInput input{0, 0, 0, double(in.egr_opening), double(in.vgt_position)};
    State now = x;
    for (int i = 0; i < kSubsteps; ++i) {
        const MeanValueFlows w = model_.flows(input, 1e3 * now(0), 1e3 * per_exhaust * now(3));
        const double egr = 1e3 * w.egr_kgps + now(4), turbine = 1e3 * w.turbine_kgps + now(5), air = double(in.air_gps),
            dt = kMatchedPeriodS / kSubsteps;
        const double filling = 1e-6 * (kAirJpkgk * s.charge_k * air + kExhaustJpkgk * s.egr_k * egr) / s.intake_m3;
        const Eigen::Vector4d rate(s.heat_ratio * (filling - k * now(0)), air - k * now(1), egr - k * now(2),
                                   k * (now(1) + now(2)) + double(in.fuel_gps) - egr - turbine);
        now.head<4>() += dt * rate;
    }
    return now;
}

Eigen::Vector2d MatchedFilter::step(const sd_airpath_in_f32_t &in) {
    const AirPathSystem &s = setup_->system;
    const double per_exhaust = 1e-6 * kExhaustJpkgk * s.exhaust_k / s.exhaust_m3;
    if (!begun_) {
        const double k = model_.emptying_ps(double(in.speed_rpm) * kRadpsPerRpm), air = double(in.air_gps) / k;
        x_.head<4>() << double(in.intake_kpa), air, 4.0, double(in.exhaust_kpa) / per_exhaust;
        p_.diagonal() << 1, 1, 4, 0.01, 0, 0;
        begun_ = true;
    }
    const State predicted = moved(x_, in);
    Eigen::Matrix<double, 6, 6> f;
    for (int j = 0; j < 6; ++j) {
        const double d = 1e-4;
        State other = x_;
        other(j) += d;
        f.col(j) = (moved(other, in) - predicted) / d;
    }
    const double air = kAirNoise * double(in.air_gps) * kMatchedPeriodS;
    Eigen::Matrix<double, 6, 1> fed = Eigen::Matrix<double, 6, 1>::Zero();
    fed(0) = s.heat_ratio * 1e-6 * kAirJpkgk * s.charge_k / s.intake_m3 * air, fed(1) = air;
    x_ = predicted;
    p_ = (f * p_ * f.transpose() + fed * fed.transpose()).eval();
    p_(4, 4) += walk_gps_ * walk_gps_, p_(5, 5) += walk_gps_ * walk_gps_;
    Eigen::Matrix<double, 2, 6> h = Eigen::Matrix<double, 2, 6>::Zero();
    h(0, 0) = 1, h(1, 3) = per_exhaust;
    const double *sigma = setup_->design.sigma_kpa;
    s_ = h * p_ * h.transpose();
    s_(0, 0) += sigma[0] * sigma[0], s_(1, 1) += sigma[1] * sigma[1];
    const Eigen::Vector2d innovation(double(in.intake_kpa) - x_(0), double(in.exhaust_kpa) - per_exhaust * x_(3));
    const Eigen::Matrix<double, 6, 2> gain = p_ * h.transpose() * s_.inverse();
    x_ += gain * innovation;
    p_ = (p_ - gain * h * p_).eval();
    return innovation;
}

} // namespace sixdeg
