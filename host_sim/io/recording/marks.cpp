// SPDX-License-Identifier: MIT
#include "io/recording/marks.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace sixdeg {
namespace {

// A gap of one missing tooth measures 1.6 and more. Rough teeth reach that too, so the gap of two or three is
// looked for with higher floors as well.
constexpr double kFloors[] = {1.6, 2.1, 2.6};
constexpr double kRatioMax = 4.5;
// How far the tooth interval around a mark is looked at; less than half the teeth of the smallest wheel.
constexpr std::size_t kNeighbourhood = 4;
// The other edge of a wide tooth falls inside the gap and splits it in two. An unequal split still looks like
// a mark, but leaves an odd interval beside it, which no wheel has.
constexpr double kBesideMin = 0.75, kBesideMax = 1.3, kSplitGap = 1.0 / 3;

// Wheels that are made: 58 teeth mean 60-2 even where the gap measures 3.6 teeth, as it may.
constexpr double kRatioTolerance = 1.5;
struct Pattern {
    int positions, missing;
};
constexpr Pattern kCommon[] = {{60, 2}, {60, 1}, {36, 1},  {36, 2},  {24, 1}, {24, 2}, {30, 1},
                               {30, 2}, {12, 1}, {12, 2},  {12, 3},  {20, 1}, {40, 1}, {44, 2},
                               {48, 1}, {48, 2}, {120, 1}, {120, 2}, {120, 3}};

constexpr int kTeethMin = 9, kTeethMax = 119;

/// Teeth between the marks of a wheel; one number for a wheel with one mark.
std::set<int> teeth_between_marks(const Wheel &wheel) {
    std::set<int> counts;
    int teeth = 0;
    for (int position = 0, k = 0; position < wheel.positions; ++position) {
        if (wheel.missing[std::size_t(k)] != position) {
            ++teeth;
            continue;
        }
        if (teeth) counts.insert(teeth);
        teeth = 0;
        k = std::min(k + 1, int(wheel.missing.size()) - 1);
    }
    return counts;
}

/// The tooth interval around a mark, free of the intervals next to it.
double pitch_around(const std::vector<double> &interval_s, std::size_t mark) {
    std::vector<double> around;
    for (std::size_t d = 2; d <= kNeighbourhood; ++d) {
        if (mark >= d) around.push_back(interval_s[mark - d]);
        if (mark + d < interval_s.size()) around.push_back(interval_s[mark + d]);
    }
    return median(std::move(around));
}

bool is_tooth(double share_of_pitch) { return share_of_pitch > kBesideMin && share_of_pitch < kBesideMax; }

/// Judges the marks as those of a wheel with so many teeth between them.
Fit judge(const std::vector<double> &interval_s, const std::vector<std::size_t> &marks, int teeth) {
    Fit fit{marks, teeth, 0, 0, 0, 0};
    std::vector<double> ratios, before, after;
    int run = 0;
    for (std::size_t k = 1; k < marks.size(); ++k) {
        const std::size_t i = marks[k];
        run = int(i - marks[k - 1]) == teeth ? run + 1 : 0;
        if (run == 0) continue;
        fit.longest_run = std::max(fit.longest_run, run);
        const double pitch_s = pitch_around(interval_s, i);
        ratios.push_back(interval_s[i] / interval_s[i - 1]);
        before.push_back(interval_s[i - 1] / pitch_s);
        after.push_back(interval_s[i + 1] / pitch_s);
    }
    if (ratios.empty()) return fit;
    fit.consistent = int(ratios.size());
    fit.gap_ratio = median(std::move(ratios));
    const bool is_one_gap = is_tooth(median(std::move(before))) && is_tooth(median(std::move(after)));
    fit.score = fit.consistent * teeth * (is_one_gap ? 1 : kSplitGap);
    return fit;
}

Fit fit_marks(const std::vector<double> &interval_s, const std::vector<std::size_t> &marks,
              const Wheel *wheel) {
    std::set<int> candidates;
    if (wheel) {
        candidates = teeth_between_marks(*wheel);
    } else {
        for (std::size_t k = 1; k < marks.size(); ++k) {
            const std::size_t teeth = marks[k] - marks[k - 1];
            if (teeth >= kTeethMin && teeth <= kTeethMax) candidates.insert(int(teeth));
        }
    }
    Fit best;
    best.marks = marks;
    for (int teeth : candidates) {
        Fit fit = judge(interval_s, marks, teeth);
        if (fit.score > best.score) best = std::move(fit);
    }
    return best;
}

} // namespace

std::vector<double> intervals(const std::vector<double> &time_s) {
    std::vector<double> interval_s;
    for (std::size_t i = 1; i < time_s.size(); ++i) interval_s.push_back(time_s[i] - time_s[i - 1]);
    return interval_s;
}

std::vector<std::size_t> find_marks(const std::vector<double> &interval_s, double floor) {
    std::vector<std::size_t> marks;
    for (std::size_t i = 1; i + 1 < interval_s.size(); ++i) {
        const double before = interval_s[i - 1], here = interval_s[i], after = interval_s[i + 1];
        if (before <= 0 || after <= 0) continue; // two edges at one time
        if (here >= floor * std::max(before, after) && here <= kRatioMax * (before + after) / 2)
            marks.push_back(i);
    }
    return marks;
}

Fit fit_wheel(const std::vector<double> &interval_s, const Wheel *wheel) {
    Fit best;
    for (double floor : kFloors) {
        Fit fit = fit_marks(interval_s, find_marks(interval_s, floor), wheel);
        if (fit.score > best.score || best.marks.empty()) best = std::move(fit);
    }
    return best;
}

Wheel wheel_of(int teeth, double gap_ratio) {
    int missing = std::clamp(int(std::lround(gap_ratio)) - 1, 1, 3);
    for (const Pattern &common : kCommon) {
        const bool fits = std::abs(gap_ratio - 1 - common.missing) < kRatioTolerance;
        if (common.positions - common.missing == teeth && fits) missing = common.missing;
    }
    missing = std::clamp(missing, std::max(1, 12 - teeth), std::min(3, 120 - teeth));
    Wheel wheel{teeth + missing, {}};
    for (int i = 0; i < missing; ++i) wheel.missing.push_back(teeth + i);
    return wheel;
}

double roughness(const std::vector<double> &interval_s) {
    std::vector<double> deviations;
    for (std::size_t i = 1; i + 1 < interval_s.size(); ++i) {
        const double expected = (interval_s[i - 1] + interval_s[i + 1]) / 2;
        if (expected > 0) deviations.push_back(std::abs(interval_s[i] / expected - 1));
    }
    return deviations.empty() ? 0 : median(std::move(deviations));
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace sixdeg
