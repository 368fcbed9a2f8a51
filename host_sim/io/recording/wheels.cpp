// SPDX-License-Identifier: MIT
#include "io/recording/wheels.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr int kPositionsMin = 12, kPositionsMax = 120, kRunMax = 3;
// A mark may measure so much more or less than drawn, in spacings.
constexpr double kWidthTolerance = 1.6;
// How much nearer than another a wheel that is made counts, and three missing teeth, which are rare, further.
constexpr double kMade = 0.6, kMadeOfMany = 1.2, kThreeMissing = 0.5;

// A width from the course of the whole revolution is taken where its deviation, in spacings, is below.
constexpr double kPoorlyKnown = 0.3;

struct Pattern {
    int positions, missing;
};
constexpr Pattern kCommon[] = {{60, 2}, {60, 1}, {36, 1}, {36, 2}, {24, 1}, {24, 2}, {30, 1}, {30, 2},  {12, 1},  {12, 2},
                               {12, 3}, {20, 1}, {40, 1}, {44, 2}, {48, 1}, {48, 2}, {90, 2}, {120, 1}, {120, 2}, {120, 3}};
constexpr int kCommonPositions[] = {12, 20, 24, 30, 36, 40, 44, 48, 60, 72, 90, 120};

struct Repeating {
    int positions, missing, times;
};
// 44-2-2, 60-2-2, 60-2-2-2, 66-2-2-2, 36-2-2: their marks lie evenly, so that a half or a third of a revolution looks like a whole one.
constexpr Repeating kRepeating[] = {{22, 2, 2}, {30, 2, 2}, {20, 2, 3}, {22, 2, 3}, {18, 2, 2}};

bool is_made(const std::vector<int> &runs, int positions) {
    if (runs.size() > 1)
        return std::find(std::begin(kCommonPositions), std::end(kCommonPositions), positions) != std::end(kCommonPositions);
    return std::any_of(std::begin(kCommon), std::end(kCommon),
                       [&](const Pattern &p) { return p.positions == positions && p.missing == runs[0]; });
}

Wheel wheel_from(const std::vector<Mark> &turn, const std::vector<int> &runs) {
    Wheel wheel;
    wheel.missing.clear();
    int position = 0;
    for (std::size_t j = 0; j < turn.size(); ++j) {
        position += turn[j].teeth;
        for (int i = 0; i < runs[j]; ++i) wheel.missing.push_back(position++);
    }
    wheel.positions = position;
    return wheel;
}

/// From the whole revolution where that is known better than from the intervals beside the marks.
std::vector<MeasuredWidth> widths_if(const Fit &fit, const std::vector<int> &runs) {
    std::vector<MeasuredWidth> widths = widths_of(fit.usual, runs);
    widths.resize(fit.turn.size(), {0, std::numeric_limits<double>::infinity()});
    for (std::size_t j = 0; j < widths.size(); ++j)
        if (!std::isnan(widths[j].spacings) && !(widths[j].sd < kPoorlyKnown)) widths[j] = {fit.turn[j].width, fit.turn[j].sd};
    return widths;
}

} // namespace

std::vector<WheelName> wheels_of(const Fit &fit) {
    const std::vector<Mark> &turn = fit.turn;
    std::vector<WheelName> names;
    if (turn.empty()) return names;
    std::vector<int> runs(turn.size(), 1);
    for (bool more = true; more;) {
        const Wheel wheel = wheel_from(turn, runs);
        const std::vector<MeasuredWidth> widths = widths_if(fit, runs);
        double doubt = !is_made(runs, wheel.positions) ? 0 : runs.size() > 1 ? -kMadeOfMany : -kMade, worst = 0, sd = 0;
        for (std::size_t j = 0; j < turn.size(); ++j) {
            const double off = std::abs(widths[j].spacings - 1 - runs[j]);
            doubt += off + (runs[j] == kRunMax && !(runs.size() == 1 && is_made(runs, wheel.positions)) ? kThreeMissing : 0);
            worst = std::isnan(off) ? off : std::max(worst, off);
            sd = std::max(sd, widths[j].sd);
        }
        const bool far = std::isnan(worst) || (worst > kWidthTolerance && turn.size() > 1);
        if (!far && wheel.positions >= kPositionsMin && wheel.positions <= kPositionsMax)
            names.push_back({wheel, doubt, sd, widths.back().spacings});
        more = false; // the next combination of 1, 2, 3
        for (int &run : runs) {
            if (run < kRunMax) {
                ++run, more = true;
                break;
            }
            run = 1;
        }
    }
    std::stable_sort(names.begin(), names.end(), [](const WheelName &a, const WheelName &b) { return a.doubt < b.doubt; });
    return names;
}

std::vector<int> marks_of(const Wheel &wheel) {
    std::vector<int> teeth;
    int run = 0;
    for (int position = 0; position < wheel.positions; ++position) {
        const bool missing = std::binary_search(wheel.missing.begin(), wheel.missing.end(), position);
        if (missing && run > 0) teeth.push_back(run);
        run = missing ? 0 : run + 1;
    }
    for (std::size_t part = 1; part < teeth.size(); ++part) {
        if (teeth.size() % part) continue;
        bool repeats = true;
        for (std::size_t i = part; i < teeth.size(); ++i) repeats &= teeth[i] == teeth[i - part];
        if (repeats) return {teeth.begin(), teeth.begin() + std::ptrdiff_t(part)};
    }
    return teeth;
}

bool is_turn_of(const std::vector<Mark> &turn, const std::vector<int> &teeth) {
    if (turn.size() != teeth.size()) return false;
    for (std::size_t from = 0; from < teeth.size(); ++from) {
        bool same = true;
        for (std::size_t j = 0; j < teeth.size(); ++j) same &= turn[j].teeth == teeth[(from + j) % teeth.size()];
        if (same) return true;
    }
    return false;
}

std::vector<int> repeated_as(const Wheel &wheel) {
    std::vector<int> times;
    for (const Repeating &known : kRepeating) {
        if (known.positions == wheel.positions && known.missing == int(wheel.missing.size()) && marks_of(wheel).size() == 1)
            times.push_back(known.times);
    }
    return times;
}

Wheel repeated(const Wheel &wheel, int times) {
    Wheel whole{wheel.positions * times, {}};
    for (int part = 0; part < times; ++part)
        for (int missing : wheel.missing) whole.missing.push_back(part * wheel.positions + missing);
    return whole;
}

WheelText parse_wheel_text(const std::string &text, const std::string &from) {
    WheelText wheel;
    int used = 0;
    const bool added = std::sscanf(text.c_str(), "%d+1%n", &wheel.positions, &used) == 1 && used == int(text.size());
    wheel.added = added;
    bool good = added || (std::sscanf(text.c_str(), "%d%n", &wheel.positions, &used) == 1 && used > 0);
    for (std::size_t at = std::size_t(used); good && !added && at < text.size();) {
        int run = 0, length = 0;
        good = std::sscanf(text.c_str() + at, "-%d%n", &run, &length) == 1 && run >= 1 && run <= kRunMax;
        wheel.runs.push_back(run);
        at += std::size_t(length);
    }
    good = good && wheel.positions >= kPositionsMin && wheel.positions <= kPositionsMax &&
           (added || (!wheel.runs.empty() && wheel.runs.size() <= 4));
    if (good) return wheel;
    throw InputError(
        from, "",
        fmt::format("'{}' is not a wheel like 60-2, 36-2-1 or 24+1: {} to {} positions, 1 to {} missing at each of up to 4 marks", text,
                    kPositionsMin, kPositionsMax, kRunMax));
}

bool is_named(const Wheel &wheel, const WheelText &text) {
    std::vector<int> runs = missing_runs(wheel), wanted = text.runs;
    std::sort(runs.begin(), runs.end());
    std::sort(wanted.begin(), wanted.end());
    return !text.added && wheel.positions == text.positions && runs == wanted;
}

} // namespace sixdeg
