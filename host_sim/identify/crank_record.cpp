// SPDX-License-Identifier: MIT
#include "identify/crank_record.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sixdeg {
namespace {

/// Largest value that holds anywhere in [from, to]; NaN where nothing was read before its end.
double largest_within(const std::vector<TimedValue> &readings, double from_s, double to_s) {
    const auto later = [](double t, const TimedValue &r) { return t < r.t_s; };
    auto at = std::upper_bound(readings.begin(), readings.end(), from_s, later);
    const auto end = std::upper_bound(at, readings.end(), to_s, later);
    if (at != readings.begin()) --at;
    double most = std::numeric_limits<double>::quiet_NaN();
    for (; at != end; ++at) most = std::fmax(most, at->value);
    return most;
}

/// What burns in a cycle was injected up to a cycle before its start.
bool is_motored(const CrankRecord &record, const std::vector<TimeWindow> &windows, const WholeCycle &cycle) {
    const double from = cycle.t_s.front(), to = cycle.t_s.back(), before = from - (to - from);
    if (std::any_of(windows.begin(), windows.end(), [&](const TimeWindow &w) { return w.from_s <= before && to <= w.to_s; })) return true;
    return !record.fuel.empty() && largest_within(record.fuel, before, to) <= 0;
}

} // namespace

double mean_within(const std::vector<TimedValue> &readings, double from_s, double to_s) {
    const auto later = [](double t, const TimedValue &r) { return t < r.t_s; };
    auto at = std::upper_bound(readings.begin(), readings.end(), from_s, later);
    const auto end = std::upper_bound(at, readings.end(), to_s, later);
    if (at != readings.begin()) --at;
    double sum = 0;
    const auto count = double(end - at);
    for (; at != end; ++at) sum += at->value;
    return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

std::vector<WholeCycle> whole_cycles(const EngineFile &engine, const CrankRecord &record, const std::vector<TimeWindow> &motored) {
    const double pitch = 360.0 / engine.wheel.positions;
    const auto degrees = [&](const PlacedTooth &tooth) { return engine.position_0_deg + pitch * double(tooth.place); };
    const std::size_t wanted = 2 * std::size_t(engine.wheel.teeth());
    std::vector<WholeCycle> cycles;
    for (std::size_t i = 0; i < record.teeth.size();) {
        const double number = std::floor((degrees(record.teeth[i]) + 360) / 720), top = 720 * number;
        WholeCycle cycle{};
        for (; i < record.teeth.size() && degrees(record.teeth[i]) < top + 360; ++i) {
            const PlacedTooth &tooth = record.teeth[i];
            if (degrees(tooth) < top - 360) break; // the angle was lost and counts anew
            cycle.t_s.push_back(tooth.t_s);
            cycle.deg.push_back(degrees(tooth) - top);
            cycle.position.push_back(int(((tooth.place % engine.wheel.positions) + engine.wheel.positions) % engine.wheel.positions));
        }
        if (cycle.t_s.size() != wanted) continue;
        cycle.speed_radps = (cycle.deg.back() - cycle.deg.front()) * M_PI / 180 / (cycle.t_s.back() - cycle.t_s.front());
        cycle.motored = is_motored(record, motored, cycle);
        cycle.intake_bar = mean_within(record.intake, cycle.t_s.front(), cycle.t_s.back());
        cycles.push_back(std::move(cycle));
    }
    return cycles;
}

} // namespace sixdeg
