// SPDX-License-Identifier: MIT
#include "studies/observers/hybrid_plant.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

/// Free oscillation about the rest position of a constant input.
HybridState constant_input(const HybridEngine &engine, double input_mps3, const HybridState &at, double dt_s) {
    const double rest = input_mps3 / engine.k1_per_s2, decay = engine.k2_per_s / 2;
    const double rate = std::sqrt(engine.k1_per_s2 - decay * decay);
    const double off = at.speed_mps - rest, shrink = std::exp(-decay * dt_s);
    const double c = shrink * std::cos(rate * dt_s), s = shrink * std::sin(rate * dt_s) / rate;
    return {rest + off * c + (at.accel_mps2 + decay * off) * s,
            at.accel_mps2 * c - (engine.k1_per_s2 * off + decay * at.accel_mps2) * s};
}

constexpr double kFineS = 2e-5; ///< The nonlinear input is constant for so long.

double expansion(const HybridEngine &engine, double since_s) {
    const double x = engine.head_m + engine.crank_radius_m * (1 - std::cos(since_s * engine.speed_radps));
    return std::pow(engine.head_m / x, engine.adiabatic);
}

/// Mean of the expansion over an interval, so that both engines have the same mean input.
double mean_expansion(const HybridEngine &engine) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += expansion(engine, (i + 0.5) / kSteps * engine.interval_s()) / kSteps;
    return sum;
}

} // namespace

double HybridEngine::input_mps3(double since_s) const {
    if (!nonlinear) return since_s >= 0 && since_s < pulse_s() ? pulse_input_mps3() : 0;
    if (!(since_s >= 0 && since_s < interval_s())) return 0;
    static const double mean = mean_expansion(HybridEngine{});
    return mean_input_mps3 * expansion(*this, since_s) / mean;
}

double HybridEngine::mean_input(double from_s, double to_s) const {
    if (!nonlinear) {
        const double overlap = std::min(to_s, pulse_s()) - std::max(from_s, 0.0);
        return overlap > 0 ? pulse_input_mps3() * overlap / (to_s - from_s) : 0;
    }
    const int parts = std::max(1, int(std::lround((to_s - from_s) / kFineS)));
    double sum = 0;
    for (int i = 0; i < parts; ++i) sum += input_mps3(from_s + (i + 0.5) * (to_s - from_s) / parts) / parts;
    return sum;
}

HybridState hybrid_advance(const HybridEngine &engine, const FiringStrength &strength, HybridState state, double from_s,
                           double to_s) {
    const double interval = engine.interval_s();
    long firing = long(std::floor(from_s / interval));
    for (double now = from_s; now < to_s; ++firing) {
        const double start = firing * interval, end = std::min(to_s, start + interval);
        const double pulse_end = engine.nonlinear ? end : std::min(to_s, start + engine.pulse_s());
        while (now < pulse_end) {
            const double next = engine.nonlinear ? std::min(pulse_end, now + kFineS) : pulse_end;
            state = constant_input(engine, strength(firing) * engine.mean_input(now - start, next - start), state, next - now);
            now = next;
        }
        if (now < end) state = constant_input(engine, 0, state, end - now);
        now = std::max(now, end);
    }
    return state;
}

HybridState hybrid_periodic_start(const HybridEngine &engine) {
    const long firings = engine.nonlinear ? 100 : 4000; // 3 s or two minutes of engine time: nothing of the start is left
    return hybrid_advance(engine, [](long) { return 1.0; }, {}, 0, firings * engine.interval_s());
}

} // namespace sixdeg
