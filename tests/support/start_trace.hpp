// SPDX-License-Identifier: MIT
// Crank edges of an engine that begins to turn, with an oracle. Shares no code with the decoder.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace sixdeg::test {

/// One start. The speed follows the angle, so that ripple stands still on the crank as compression does.
struct StartTrace {
    int positions = 60;
    std::vector<int> missing{58, 59};
    double mark_ratio = 3;               ///< Interval over every mark, in tooth spacings.
    double before = 1, after = 1;        ///< The intervals right before and right after every mark, in tooth spacings.
    double rpm = 200, rpm_per_s = 0;
    double ripple = 0, ripple_phase = 0; ///< Speed = rpm (1 + ripple sin(2 angle + ripple_phase)); phase: where the mark stands.
    double jitter = 0;                   ///< Standard deviation of each edge, in tooth spacings.
    double drop_rate = 0, add_rate = 0;  ///< A true tooth.
    bool bursts = false;                 ///< Faults come two or three at a time.
    int first = 20;                      ///< The recording begins after this tooth, counted from 0 at the first mark's end.
    double revolutions = 4;
    double tick_hz = 1e6;
};

struct StartEdge {
    std::int64_t tick;
    int position;       ///< True tooth position; -1 for a spurious edge.
    double place;       ///< True position at that time, fractions included.
    int marks;          ///< Marks passed so far; one counts when the interval before it was captured too.
    int teeth_since;    ///< Teeth since the last mark.
    double revolutions; ///< Turned since the recording began.
};

/// The teeth of a wheel: where they stand and how far from the tooth before.
struct StartWheel {
    std::vector<int> position;
    std::vector<double> spacings;
    double pitch_rad;

    explicit StartWheel(const StartTrace &w) {
        for (int p = 0; p < w.positions; ++p) {
            if (std::find(w.missing.begin(), w.missing.end(), p) == w.missing.end()) position.push_back(p);
        }
        const std::size_t n = position.size();
        const auto gap_before = [&](std::size_t i) {
            return (position[i % n] - position[(i + n - 1) % n] + w.positions) % w.positions > 1;
        };
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
            spacings.push_back(gap_before(i) ? w.mark_ratio : gap_before(i + 1) ? w.before : gap_before(i + n - 1) ? w.after : 1);
            sum += spacings.back();
        }
        pitch_rad = 2 * M_PI / sum;
    }
    std::size_t teeth() const { return position.size(); }
};

inline std::vector<StartEdge> start_edges(const StartTrace &w, std::mt19937_64 &random) {
    const StartWheel wheel(w);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<double> normal(0, 1);
    const auto burst = [&] { return w.bursts ? 2 + int(uniform(random) < 0.5) : 1; };
    std::size_t tooth = std::size_t(w.first) % wheel.teeth();
    double angle = 0, time = 0.01, turned = 0;
    for (std::size_t i = 1; i <= tooth; ++i) angle += wheel.spacings[i] * wheel.pitch_rad;
    int marks = 0, since = 0, dropping = 0;
    std::vector<StartEdge> edges;
    const auto put = [&](double at_s, int position, double place) {
        edges.push_back({std::int64_t(std::llround(at_s * w.tick_hz)), position, place, marks, since, turned});
    };
    for (std::size_t k = 0; turned < w.revolutions; ++k) {
        const std::size_t next = (tooth + 1) % wheel.teeth();
        const double span_rad = wheel.spacings[next] * wheel.pitch_rad, begin = time;
        constexpr int kParts = 8;
        for (int i = 0; i < kParts; ++i) {
            const double at = angle + (i + 0.5) * span_rad / kParts;
            const double rpm = std::fmax(w.rpm + w.rpm_per_s * time, 50) * (1 + w.ripple * std::sin(2 * at + w.ripple_phase));
            time += span_rad / kParts / (rpm * M_PI / 30);
        }
        angle += span_rad;
        turned += span_rad / (2 * M_PI);
        const int from = wheel.position[tooth], steps = (wheel.position[next] - from + w.positions) % w.positions;
        if (w.add_rate > 0 && uniform(random) < w.add_rate) {
            for (int n = burst(); n > 0; --n) {
                const double u = uniform(random);
                put(begin + u * (time - begin), -1, from + u * steps);
            }
        }
        tooth = next;
        since = steps > 1 ? 0 : since + 1;
        marks += steps > 1 && k >= 2;
        if (dropping == 0 && w.drop_rate > 0 && uniform(random) < w.drop_rate) dropping = burst();
        if (dropping > 0) {
            --dropping;
            continue;
        }
        const double late = w.jitter > 0 ? w.jitter * normal(random) * (time - begin) / wheel.spacings[next] : 0;
        put(time + late, wheel.position[tooth], wheel.position[tooth]);
    }
    std::stable_sort(edges.begin(), edges.end(), [](const StartEdge &a, const StartEdge &b) { return a.tick < b.tick; });
    return edges;
}

} // namespace sixdeg::test
