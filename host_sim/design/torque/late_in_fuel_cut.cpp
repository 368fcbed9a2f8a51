// SPDX-License-Identifier: MIT
#include "design/torque/late_in_fuel_cut.hpp"

#include <algorithm>
#include <cmath>

extern "C" {
#include "sd_pattern.h"
}

namespace sixdeg {
namespace {

/// Over a cycle from tooth 0 on, which is not late: rad over J_mean w^2, [2 N].
std::vector<double> late_over_cycle(const EngineFile &engine, const TorqueOverAngle &torque) {
    const auto [mean, moment] = interval_tables(engine, {torque});
    const double pitch = 2 * M_PI / engine.wheel.positions, inertia = mean_inertia_kgm2(engine);
    std::vector<double> late{0};
    double energy = 0;
    for (int k = 1; k < mean.rows(); ++k) {
        late.push_back(late.back() - pitch * inertia / interval_inertia_kgm2(engine, k) * (energy + pitch * moment(k, 0)));
        energy += pitch * mean(k, 0);
    }
    return late;
}

} // namespace

std::vector<double> late_in_fuel_cut(const EngineFile &engine, const TorqueOverAngle &torque) {
    const auto late = late_over_cycle(engine, torque);
    const int n = engine.wheel.positions;
    std::vector<int> teeth;
    for (int k = 0; k < n; ++k)
        if (std::count(engine.wheel.missing.begin(), engine.wheel.missing.end(), k) == 0) teeth.push_back(k);
    const double count = double(teeth.size());
    double k_sum = 0, kk = 0, d = 0, kd = 0;
    for (int k : teeth) {
        const double at = k - n / 2.0, apart = late[std::size_t(k + n)] - late[std::size_t(k)];
        k_sum += at, kk += at * at, d += apart, kd += at * apart;
    }
    const double slope = (count * kd - k_sum * d) / (count * kk - k_sum * k_sum), a2 = slope / (2 * n);
    const double a1 = (d - slope * k_sum) / count / n - 2 * n * a2;
    const auto without_trend = [&](int k) { return late[std::size_t(k)] - a1 * k - a2 * k * k; };
    std::vector<double> out(std::size_t(n), 0.0);
    double mean = 0;
    for (int k : teeth) {
        out[std::size_t(k)] = (without_trend(k) + without_trend(k + n)) / 2;
        mean += out[std::size_t(k)] / count;
    }
    const double scale = mean_inertia_kgm2(engine) * std::pow(double(SD_PATTERN_REFERENCE_RADPS), 2);
    for (int k : teeth) out[std::size_t(k)] = (out[std::size_t(k)] - mean) / scale;
    return out;
}

} // namespace sixdeg
