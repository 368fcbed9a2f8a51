// SPDX-License-Identifier: MIT
// Synthetic crank edges with an oracle: what each edge really is. Shares no code with the decoder.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace sixdeg::test {

struct WheelTrace {
    int positions = 60;
    std::vector<int> missing{58, 59};
    double mark_ratio = 3.0;     ///< Interval over the mark / tooth interval at constant speed.
    double rpm = 2000, ripple = 0; ///< Speed = rpm (1 + ripple sin(2 angle)): compression of a four-cylinder.
    double rpm_per_s = 0;
    double jitter_teeth = 0;     ///< Standard deviation of each edge, in tooth spacings.
    double drop_rate = 0, add_rate = 0; ///< Per true tooth.
    bool bursts = false;         ///< Faults come two or three at a time instead of singly.
    double tick_hz = 1e6;
    std::uint32_t seed = 1;
};

struct OracleEdge {
    double time_s;
    std::uint32_t tick; ///< Wraps, as a capture timer does.
    int position;     ///< True tooth position, -1 for a spurious edge.
    double place;     ///< True position at that time, in positions from 0, fractions included (spurious edges too).
    bool after_fault; ///< At least one fault lies between this edge and the true tooth before it.
};

struct Trace {
    std::vector<OracleEdge> edges;
    std::uint64_t faults = 0; ///< Dropped and added edges.
};

/// `count` true teeth (dropped ones included) from the middle of a revolution.
inline Trace make_trace(const WheelTrace &w, std::size_t count) {
    std::mt19937_64 random(w.seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<double> normal(0, 1);
    const auto missing = [&](int p) { return std::find(w.missing.begin(), w.missing.end(), p) != w.missing.end(); };
    const int teeth = w.positions - int(w.missing.size());
    int marks = 0;
    for (int p = 0; p < w.positions; ++p) marks += missing(p) && !missing((p + 1) % w.positions);
    const double pitch = 2 * M_PI / (teeth - marks + marks * w.mark_ratio);

    Trace trace;
    double angle = 0, time = 0.01, rpm = w.rpm;
    int position = w.positions / 3, dropping = 0;
    bool fault = false;
    std::vector<double> extra;
    for (std::size_t k = 0; k < count; ++k) {
        int next = (position + 1) % w.positions, run = 0;
        while (missing(next)) { next = (next + 1) % w.positions; ++run; }
        const double spacing = run ? w.mark_ratio : 1.0;
        const double middle = angle + 0.5 * spacing * pitch;
        const double speed = rpm * M_PI / 30 * (1 + w.ripple * std::sin(2 * middle));
        const double step = spacing * pitch / speed;
        const double tooth = step / spacing; // time of one spacing here
        rpm += w.rpm_per_s * step;

        if (w.add_rate > 0 && uniform(random) < w.add_rate) {
            const int n = w.bursts ? 2 + int(uniform(random) < 0.5) : 1;
            std::vector<double> at;
            for (int i = 0; i < n; ++i) at.push_back(uniform(random));
            std::sort(at.begin(), at.end());
            for (double u : at) {
                const double places = position + u * (run + 1);
                trace.edges.push_back({time + u * step, 0, -1, places, true});
                ++trace.faults;
            }
            fault = true;
        }
        time += step;
        angle += spacing * pitch;
        position = next;
        if (dropping == 0 && w.drop_rate > 0 && uniform(random) < w.drop_rate) {
            dropping = w.bursts ? 2 + int(uniform(random) < 0.5) : 1;
        }
        if (dropping > 0) {
            --dropping;
            ++trace.faults;
            fault = true;
            continue;
        }
        const double at = time + w.jitter_teeth * tooth * normal(random);
        trace.edges.push_back({at, 0, position, double(position), fault});
        fault = false;
    }
    // Jitter and added edges may have passed each other.
    std::stable_sort(trace.edges.begin(), trace.edges.end(),
                     [](const OracleEdge &a, const OracleEdge &b) { return a.time_s < b.time_s; });
    for (OracleEdge &e : trace.edges) e.tick = std::uint32_t(std::uint64_t(std::llround(e.time_s * w.tick_hz)));
    return trace;
}

} // namespace sixdeg::test
