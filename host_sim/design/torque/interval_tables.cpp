// SPDX-License-Identifier: MIT
// Inertia and torques between two teeth.
#include "design/torque/interval_tables.hpp"

#include <cmath>

#include "design/crank/crank_modes.hpp"

namespace sixdeg {
namespace {
constexpr double kRadPerDeg = M_PI / 180;
} // namespace

double tooth_angle(const EngineFile &engine, double k) {
    return engine.position_0_deg * kRadPerDeg + 2 * M_PI * k / engine.wheel.positions;
}

Interval over_interval(const EngineFile &engine, const TorqueOverAngle &torque, int k) {
    constexpr int kSteps = 24;
    Interval out;
    for (int i = 0; i <= kSteps; ++i) {
        const double s = double(i) / kSteps, value = torque(tooth_angle(engine, k - 1 + s));
        const double weight = (i == 0 || i == kSteps ? 1.0 : i % 2 ? 4.0 : 2.0) / (3 * kSteps);
        out.mean += weight * value;
        out.moment += weight * (1 - s) * value;
        out.point = value;
    }
    return out;
}

double interval_inertia_kgm2(const EngineFile &engine, int k) {
    const auto root = [&](double s) { return std::sqrt(turning_inertia_kgm2(engine, tooth_angle(engine, k - 1 + s))); };
    return std::pow((root(0) + 4 * root(0.5) + root(1)) / 6, 2);
}

double mean_inertia_kgm2(const EngineFile &engine) {
    double sum = 0;
    for (int k = 0; k < engine.wheel.positions; ++k) sum += interval_inertia_kgm2(engine, k);
    return sum / engine.wheel.positions;
}

TorqueOverAngle sum_of(const std::vector<TorqueOverAngle> &torques) {
    return [torques](double a) {
        double sum = 0;
        for (const TorqueOverAngle &torque : torques) sum += torque(a);
        return sum;
    };
}

std::pair<Eigen::MatrixXd, Eigen::MatrixXd> interval_tables(const EngineFile &engine, const std::vector<TorqueOverAngle> &torques) {
    Eigen::MatrixXd mean(2 * engine.wheel.positions, torques.size()), moment = mean;
    for (int k = 0; k < mean.rows(); ++k) {
        for (int j = 0; j < mean.cols(); ++j) {
            const Interval at = over_interval(engine, torques[std::size_t(j)], k);
            mean(k, j) = at.mean, moment(k, j) = at.moment;
        }
    }
    return {mean, moment};
}

} // namespace sixdeg
