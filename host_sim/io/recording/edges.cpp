// SPDX-License-Identifier: MIT
#include "io/recording/edges.hpp"

#include <algorithm>
#include <cstdlib>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr double kJump =
    0.6; // Of the range: no crank signal that takes five rows from level to level does that.

std::vector<double> level_edges(const Recording &recording, int column, Edge edge) {
    const std::vector<double> &time_s = recording.time_s(), &value = recording.columns[std::size_t(column)];
    std::vector<double> found;
    for (std::size_t i = 1; i < value.size(); ++i) {
        const bool changed = edge == Edge::rising ? value[i] > value[i - 1] : value[i] < value[i - 1];
        if (changed) found.push_back(time_s[i]);
    }
    return found;
}

/// Some recorders let a voltage above their range come out at the bottom of it. In a slow voltage that shows
/// as a jump down between two rows and a jump back up soon after; what lies between belongs above the range.
std::vector<double> without_overflow(std::vector<double> value) {
    const auto [low, high] = std::minmax_element(value.begin(), value.end());
    const double range = *high - *low, jump = kJump * range, middle = *low + range / 2;
    long down = 0, up = 0, crossings = 0;
    for (std::size_t i = 1; i < value.size(); ++i) {
        down += value[i] - value[i - 1] < -jump;
        up += value[i] - value[i - 1] > jump;
        crossings += (value[i] < middle) != (value[i - 1] < middle);
    }
    // A logic signal sampled as a voltage jumps at nearly every crossing, and that is no overflow.
    if (down == 0 || up == 0 || std::abs(down - up) > 1 || down + up > crossings / 2) return value;
    bool above = false;
    for (std::size_t i = 1, last = value.size(); i < last; ++i) {
        // The step is taken from the row above as it was recorded.
        const double step = value[i] - (above ? value[i - 1] - range : value[i - 1]);
        if (step < -jump) above = true;
        if (step > jump) above = false;
        if (above) value[i] += range;
    }
    return value;
}

std::vector<double> sampled_edges(const Recording &recording, int column, Edge edge) {
    const std::vector<double> &time_s = recording.time_s();
    const std::vector<double> value = without_overflow(recording.columns[std::size_t(column)]);
    const Levels swing = levels(recording, column);
    // Falling edges are the rising ones of the signal upside down.
    const double sign = edge == Edge::rising ? 1 : -1;
    std::vector<double> found;
    enum { unknown, below, above } side = unknown;
    double crossing_s = 0;
    double before = sign * (value[0] - swing.threshold());
    for (std::size_t i = 0; i < value.size(); ++i) {
        const double now = sign * (value[i] - swing.threshold());
        if (before < 0 && now >= 0) {
            crossing_s = time_s[i - 1] + (time_s[i] - time_s[i - 1]) * (before / (before - now));
        }
        if (now > swing.hysteresis()) {
            if (side == below) found.push_back(crossing_s);
            side = above;
        } else if (now < -swing.hysteresis()) {
            side = below;
        }
        before = now;
    }
    return found;
}

} // namespace

std::string to_string(Edge edge) { return edge == Edge::falling ? "falling" : "rising"; }

Edge parse_edge(const std::string &text, const std::string &from) {
    if (text == "falling") return Edge::falling;
    if (text == "rising") return Edge::rising;
    throw InputError(from, "", "'" + text + "' is not an edge: falling or rising");
}

Levels levels(const Recording &recording, int column) {
    column_kind(recording, column);
    std::vector<double> sorted = recording.columns[std::size_t(column)];
    const auto outside = std::ptrdiff_t(sorted.size() / 1000);
    std::nth_element(sorted.begin(), sorted.begin() + outside, sorted.end());
    const double low = sorted[std::size_t(outside)];
    std::nth_element(sorted.begin(), sorted.end() - 1 - outside, sorted.end());
    return {low, *(sorted.end() - 1 - outside)};
}

std::vector<double> edges(const Recording &recording, int column, Edge edge) {
    switch (column_kind(recording, column)) {
    case ColumnKind::edge_times:
        return recording.time_s();
    case ColumnKind::level:
        return level_edges(recording, column, edge);
    case ColumnKind::sampled:
        return sampled_edges(recording, column, edge);
    case ColumnKind::constant:
        break;
    }
    return {};
}

} // namespace sixdeg
