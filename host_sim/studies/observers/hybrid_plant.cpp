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

} // namespace

HybridState hybrid_advance(const HybridEngine &engine, const FiringStrength &strength, HybridState state, double from_s,
                           double to_s) {
    const double interval = engine.interval_s();
    long firing = long(std::floor(from_s / interval));
    for (double now = from_s; now < to_s; ++firing) {
        const double pulse_end = std::min(to_s, firing * interval + engine.pulse_s());
        if (now < pulse_end) {
            state = constant_input(engine, strength(firing) * engine.pulse_input_mps3(), state, pulse_end - now);
            now = pulse_end;
        }
        const double end = std::min(to_s, (firing + 1) * interval);
        if (now < end) state = constant_input(engine, 0, state, end - now);
        now = std::max(now, end);
    }
    return state;
}

HybridState hybrid_periodic_start(const HybridEngine &engine) {
    const long firings = 4000; // two minutes of engine time: nothing of the start is left
    return hybrid_advance(engine, [](long) { return 1.0; }, {}, 0, firings * engine.interval_s());
}

} // namespace sixdeg
