// SPDX-License-Identifier: MIT
// Recordings of an ideal or disturbed crank wheel, made for tests; shares no code with what it tests.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace crank_trace {

constexpr double kPi = 3.14159265358979323846;

struct Trace {
    int positions = 60, missing = 2;
    double revolutions = 12;
    std::function<double(double)> rpm = [](double) {
        return 900.0;
    };                           ///< Speed over the angle in revolutions.
    double jitter = 0;           ///< Standard deviation of an edge, in tooth pitches.
    double lost = 0;             ///< Share of edges that the recorder missed.
    double start_position = 7.3; ///< Where on the wheel the recording begins.
};

/// Wheel angle over time, in positions, by small steps.
struct Motion {
    std::vector<double> time_s, position;

    explicit Motion(const Trace &trace) {
        const double step = 0.02;
        double t_s = 0.05;
        for (double p = trace.start_position; p < trace.revolutions * trace.positions; p += step) {
            time_s.push_back(t_s);
            position.push_back(p);
            t_s += step / trace.positions / (trace.rpm(p / trace.positions) / 60);
        }
    }
    double time_at(double p) const {
        const double index = (p - position.front()) / (position[1] - position[0]);
        const auto i = std::min(std::size_t(index), time_s.size() - 2);
        return time_s[i] + (index - double(i)) * (time_s[i + 1] - time_s[i]);
    }
};

/// Times of one edge a tooth, `offset` positions after the tooth's place.
inline std::vector<double> edge_times(const Trace &trace, double offset = 0) {
    const Motion motion(trace);
    std::mt19937 random(7);
    std::normal_distribution<double> jitter(0, trace.jitter > 0 ? trace.jitter : 1);
    std::uniform_real_distribution<double> chance(0, 1);
    std::vector<double> times;
    for (int p = int(std::ceil(trace.start_position)); p + 1 < trace.revolutions * trace.positions; ++p) {
        if (p % trace.positions >= trace.positions - trace.missing || chance(random) < trace.lost) continue;
        times.push_back(motion.time_at(p + offset + (trace.jitter > 0 ? jitter(random) : 0)));
    }
    return times;
}

/// Rows of "time, level" from times of falling and rising edges.
inline std::string level_rows(const std::vector<double> &falling, const std::vector<double> &rising) {
    std::vector<std::pair<double, int>> events{{0.0, rising.front() < falling.front() ? 0 : 1}};
    for (double t_s : falling) events.emplace_back(t_s, 0);
    for (double t_s : rising) events.emplace_back(t_s, 1);
    std::sort(events.begin(), events.end());
    std::string rows;
    char line[64];
    for (const auto &[t_s, level] : events) {
        std::snprintf(line, sizeof line, "%.9f, %d\n", t_s, level);
        rows += line;
    }
    return rows;
}

/// A variable-reluctance voltage at `sample_hz`: a sine over each tooth that falls through zero at its
/// middle, swings wider with speed, and leans from its low to its high over the gap. The recorder clips at
/// -1.5 V, and what exceeds `folded_over_v` comes out at the bottom of its range.
inline std::string reluctance_rows(const Trace &trace, double sample_hz, double folded_over_v = 0) {
    const Motion motion(trace);
    std::string rows;
    char line[64];
    std::size_t i = 0;
    for (double t_s = motion.time_s.front(); t_s < motion.time_s.back(); t_s += 1 / sample_hz) {
        while (motion.time_s[i + 1] < t_s) ++i;
        const double place =
            std::fmod(motion.position[i], trace.positions) - (trace.positions - trace.missing - 1);
        const double swing_v = trace.rpm(motion.position[i] / trace.positions) / 200;
        // Over the gap one slow half wave stands in for the missing teeth.
        const double shape = place < 0.25 ? std::sin(2 * kPi * place)
                             : place > trace.missing + 0.75
                                 ? std::sin(2 * kPi * place)
                                 : std::cos(kPi * (place - 0.25) / (trace.missing + 0.5));
        double v = 3.5 - swing_v * shape * (place >= 0.25 && place <= trace.missing + 0.75 ? 1.6 : 1);
        v = std::max(v, -1.5);
        if (folded_over_v > 0 && v > folded_over_v) v -= folded_over_v + 1.5;
        std::snprintf(line, sizeof line, "%.7f\t%.3f\n", t_s, v);
        rows += line;
    }
    return rows;
}

} // namespace crank_trace
