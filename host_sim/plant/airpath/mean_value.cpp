// SPDX-License-Identifier: MIT
#include "plant/airpath/mean_value.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

constexpr double kAirJpkgk = 287, kExhaustJpkgk = 286;
// Of the turbine's flow and the valve's; Wahlstrom and Eriksson, 2011.
constexpr double kTurbineFlow = 0.762, kTurbineExponent = 2.89, kChoked = 0.65;

} // namespace

double MeanValueModel::emptying_ps(double speed_radps) const {
    const double revolutions_ps = speed_radps / (2 * M_PI);
    return system_.volumetric_efficiency.at(speed_radps) * displaced_m3_ * revolutions_ps / 2 / system_.intake_m3;
}

double MeanValueModel::exhaust_pa(double kg) const { return kExhaustJpkgk * system_.exhaust_k * kg / system_.exhaust_m3; }

MeanValueFlows MeanValueModel::flows(const MeanValueInput &input, double intake_pa, double exhaust_pa) const {
    const double speed = exhaust_pa / std::sqrt(kExhaustJpkgk * system_.exhaust_k);
    const double ratio = std::clamp(intake_pa / exhaust_pa, kChoked, 1.0);
    const double short_of = (1 - ratio) / (1 - kChoked) - 1;
    const double drop = std::max(0.0, 1 - std::pow(system_.ambient_pa / exhaust_pa, kTurbineExponent));
    return {system_.egr_area_m2.at(std::clamp(input.egr_opening, 0.0, 1.0)) * speed * (1 - short_of * short_of),
            system_.turbine_area_m2.at(std::clamp(input.vgt_position, 0.0, 1.0)) * speed * kTurbineFlow * std::sqrt(drop)};
}

MeanValueModel::State MeanValueModel::rate(const MeanValueInput &input, const State &x) const {
    const double k = emptying_ps(input.speed_radps);
    const MeanValueFlows w = flows(input, x[0], exhaust_pa(x[3]));
    const double filling = (kAirJpkgk * system_.charge_k * input.air_kgps + kExhaustJpkgk * system_.egr_k * w.egr_kgps) / system_.intake_m3;
    return {system_.heat_ratio * (filling - k * x[0]), input.air_kgps - k * x[1], w.egr_kgps - k * x[2],
            k * (x[1] + x[2]) + input.fuel_kgps - w.egr_kgps - w.turbine_kgps};
}

void MeanValueModel::rest(const MeanValueInput &input) {
    // Both flows are monotone in their pressure, so halving finds it.
    const auto halve = [](double low, double high, const auto &above) {
        for (int i = 0; i < 60; ++i) (above((low + high) / 2) ? high : low) = (low + high) / 2;
        return low;
    };
    const double out = input.air_kgps + input.fuel_kgps, k = emptying_ps(input.speed_radps);
    const double exhaust = halve(system_.ambient_pa, 2e6, [&](double p) { return flows(input, p, p).turbine_kgps > out; });
    const auto egr = [&](double intake) { return flows(input, intake, exhaust).egr_kgps; };
    x_[0] = halve(1e4, 2e6, [&](double p) {
        return k * p > (kAirJpkgk * system_.charge_k * input.air_kgps + kExhaustJpkgk * system_.egr_k * egr(p)) / system_.intake_m3;
    });
    x_[1] = input.air_kgps / k;
    x_[2] = egr(x_[0]) / k;
    x_[3] = exhaust * system_.exhaust_m3 / (kExhaustJpkgk * system_.exhaust_k);
}

void MeanValueModel::step(const MeanValueInput &input, double dt_s) {
    const auto moved = [&](const State &by, double dt) {
        State x = x_;
        for (std::size_t i = 0; i < x.size(); ++i) x[i] += dt * by[i];
        return x;
    };
    const State k1 = rate(input, x_), k2 = rate(input, moved(k1, dt_s / 2)), k3 = rate(input, moved(k2, dt_s / 2)),
                k4 = rate(input, moved(k3, dt_s));
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += dt_s / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

} // namespace sixdeg
