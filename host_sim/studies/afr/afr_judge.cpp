// SPDX-License-Identifier: MIT
#include "studies/afr/afr_judge.hpp"

#include <cmath>
#include <stdexcept>

#include "common/random.hpp"
#include "linalg/linalg.hpp"
#include "studies/afr/afr_blocks.hpp"

namespace sixdeg {

AfrEstimates afr_estimate(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace,
                          const AfrSetup &setup, const std::vector<double> &noise) {
    if (setup.fixed_point) return AfrBlocks<Q31>(engine, point, trace, setup).run(noise);
    return AfrBlocks<F32>(engine, point, trace, setup).run(noise);
}

sd_afr_learned_t afr_delay_probe(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace, const AfrSetup &setup,
                           const std::vector<double> &noise, const std::vector<std::array<double, 8>> &trims) {
    return AfrBlocks<F32>(engine, point, trace, setup).probe(noise, trims);
}

std::vector<double> sensor_noise(const AfrTrace &trace, double rms, double correlation_s,
                                 std::uint64_t seed) {
    RandomStream random(seed, 1);
    std::vector<double> noise(trace.sensor.size());
    const double keep = correlation_s > 0 ? std::exp(-trace.step_s / correlation_s) : 0;
    // A density S of white noise, rms^2 = S/(2 dt), is variance S/(4 tau) when it is of first order.
    const double sd = correlation_s > 0 ? rms * std::sqrt(trace.step_s / (2 * correlation_s)) : rms;
    double state = 0;
    for (double &n : noise) n = state = keep * state + sd * std::sqrt(1 - keep * keep) * random.normal();
    return noise;
}

double afr_bound(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace, double noise_rms,
                 int cycles) {
    const int n = engine.cylinders(), states = n + 3;
    const double e1 = std::exp(-trace.step_s / engine.exhaust->uego_tau_s[0]),
                 e2 = std::exp(-trace.step_s / engine.exhaust->uego_tau_s[1]);
    Eigen::MatrixXd sensitivity =
        Eigen::MatrixXd::Identity(states, states); // rows: x, s2, s1, then cylinders
    Eigen::MatrixXd rows(cycles * trace.cycle_positions, states);
    for (int k = 0; k < rows.rows(); ++k) {
        Eigen::RowVectorXd inflow = Eigen::RowVectorXd::Zero(states);
        double passed = 0;
        for (int i = 0; i < n; ++i) {
            const int from =
                int(std::lround(engine.firing_tdc_deg[std::size_t(i)] / 360 * engine.wheel.positions));
            const double d =
                point.charge_kg *
                point.share[std::size_t((k - from + 2 * trace.cycle_positions) % trace.cycle_positions)];
            inflow += d * sensitivity.row(3 + i);
            passed += d;
        }
        sensitivity.row(0) = (point.mean_kg * sensitivity.row(0) + inflow) / (point.mean_kg + passed);
        sensitivity.row(1) = e2 * sensitivity.row(1) + (1 - e2) * sensitivity.row(0);
        sensitivity.row(2) = e1 * sensitivity.row(2) + (1 - e1) * sensitivity.row(1);
        rows.row(k) = sensitivity.row(2) / noise_rms;
    }
    const Eigen::MatrixXd inverse = linalg::inverse_of_triangle(linalg::upper_triangle(rows));
    Eigen::VectorXd contrast = Eigen::VectorXd::Zero(states);
    for (int i = 0; i < n; ++i) contrast(3 + i) = (i == 0 ? 1.0 : 0.0) - 1.0 / n;
    return (inverse.transpose() * contrast).norm();
}

} // namespace sixdeg
