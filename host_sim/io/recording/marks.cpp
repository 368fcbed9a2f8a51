// SPDX-License-Identifier: MIT
#include "io/recording/marks.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "io/recording/wheels.hpp"

namespace sixdeg {
namespace {

// A gap of one missing tooth measures 1.6 and more. Rough teeth reach that too, so the gap of two or three is
// looked for with higher floors as well; where teeth beside the mark are wide, a lower one finds it.
constexpr double kFloors[] = {1.6, 2.1, 2.6, 1.35};
constexpr double kRatioMax = 4.5;
// Three missing of twelve, where the crank is slowest.
constexpr double kWideFloor = 2.6, kWideMax = 7;
// How far the tooth interval around a mark is looked at; less than half the teeth of the smallest wheel.
constexpr std::size_t kNeighbourhood = 4;
// The other edge of a wide tooth falls inside the gap and splits it in two. An unequal split still looks like
// a mark, but leaves an odd interval beside it, which no wheel has.
// A tooth beside the mark may be weak, too, and its edge late.
constexpr double kBesideMin = 0.75, kWeakMin = 0.6, kBesideMax = 1.3, kSplitGap = 1.0 / 3, kWeakTooth = 0.7;
// A wheel of more marks explains more edges, or it is chance.
constexpr double kMoreMarks = 1.2;
constexpr double kMostSteps = 0.75, kNearlyAll = 0.95; // Of the steps from mark to mark that fit.
constexpr int kMarksMax = 4, kTeethMin = 9, kTeethMax = 119;
// Over the mean of its neighbours, in the median of so many revolutions: what a mark of one missing tooth has beside wide teeth.
constexpr double kLesserMark = 1.4, kNearlyAlways = 1.25, kBeyondNoise = 4;
// Of two intervals over the greater beside them. The slowest two of nine reach 1.5 under a ripple of 40 %, of twenty 1.2.
constexpr double kPairOfFew = 1.8, kPairOfMany = 1.45;
constexpr int kManyTeeth = 20;
constexpr int kRevolutionsToLook = 3;
constexpr double kBendDoubts = 1.5;
// Of the intervals' logarithms: what counts when a revolution is sought by likeness, and how many are looked at.
constexpr double kLeastPeak = 0.3;
constexpr std::size_t kLikenessMax = 20000, kLikely = 3;

/// The interval over the mean of its neighbours.
double standing_out(const std::vector<double> &interval_s, std::size_t i) {
    return 2 * interval_s[i] / std::max(interval_s[i - 1] + interval_s[i + 1], 1e-12);
}

/// The lesser of this interval and the next over the greater of those on either side: two marks with one tooth between them.
double standing_out_together(const std::vector<double> &interval_s, std::size_t i) {
    if (i + 2 >= interval_s.size()) return 0;
    return std::min(interval_s[i], interval_s[i + 1]) / std::max(std::max(interval_s[i - 1], interval_s[i + 2]), 1e-12);
}

/// Whether the median is so large, and three quarters nearly.
bool is_usually(std::vector<double> &ratio, double least) {
    std::sort(ratio.begin(), ratio.end());
    return ratio[ratio.size() / 2] >= least && ratio[ratio.size() / 4] >= kNearlyAlways;
}

/// The tooth interval around a mark, free of the intervals next to it.
double pitch_around(const std::vector<double> &interval_s, std::size_t mark) {
    std::vector<double> around;
    for (std::size_t d = 2; d <= kNeighbourhood; ++d) {
        if (mark >= d) around.push_back(interval_s[mark - d]);
        if (mark + d < interval_s.size()) around.push_back(interval_s[mark + d]);
    }
    return around.empty() ? interval_s[mark] : median(std::move(around));
}

/// How much a train is believed whose mark has such intervals beside it.
double believed(double before, double after) {
    const double least = std::min(before, after);
    if (std::max(before, after) >= kBesideMax || least <= kWeakMin) return kSplitGap;
    return least > kBesideMin ? 1 : kWeakTooth;
}

/// Marks k whose `count` predecessors make a revolution like the one before.
std::vector<std::size_t> repeats(const std::vector<std::size_t> &marks, std::size_t count, int teeth) {
    std::vector<std::size_t> found;
    for (std::size_t k = count; k < marks.size(); ++k) {
        if (int(marks[k] - marks[k - count]) != teeth) continue;
        if (count > 1 && k > count && marks[k] - marks[k - 1] != marks[k - count] - marks[k - count - 1]) continue;
        found.push_back(k);
    }
    return found;
}

/// Teeth before each mark of the revolution that ends with mark k.
std::vector<int> steps_before(const std::vector<std::size_t> &marks, std::size_t k, std::size_t count) {
    std::vector<int> steps;
    for (std::size_t i = k + 1 - count; i <= k; ++i) steps.push_back(int(marks[i] - marks[i - 1]));
    return steps;
}

/// Standard deviation, from the median distance to the median.
double scatter(std::vector<double> values) {
    const double middle = median(values);
    for (double &value : values) value = std::abs(value - middle);
    return 1.4826 * median(std::move(values));
}

/// Width of a mark in tooth spacings, from the medians of what all revolutions show around it. What a spacing would take at the mark
/// follows from the intervals two and three away, with their bend, since speed may be lowest there.
Mark measured(const std::vector<double> &interval_s, const std::vector<std::size_t> &places, int teeth) {
    std::vector<double> own, near, far;
    for (std::size_t i : places) {
        const double pitch_s = pitch_around(interval_s, i);
        own.push_back(interval_s[i] / pitch_s);
        if (i < 3 || i + 3 >= interval_s.size()) continue;
        near.push_back((interval_s[i - 2] + interval_s[i + 2]) / 2 / pitch_s);
        far.push_back((interval_s[i - 3] + interval_s[i + 3]) / 2 / pitch_s);
    }
    const double middle = median(own), count = double(own.size());
    // Only as much of the bend as noise does not make.
    const double bend = near.empty() ? 0 : 2 * median(near) - median(far) - 1;
    const double doubt = near.empty() ? 0 : kBendDoubts * 1.25 * std::hypot(2 * scatter(near), scatter(far)) / std::sqrt(count);
    const double here = std::clamp(1 + std::copysign(std::max(0.0, std::abs(bend) - doubt), bend), 0.5, 1.6);
    return {teeth, middle / here, 1.25 * scatter(own) / std::sqrt(count)};
}

/// The order of marks that most revolutions show, turned so that the widest mark is last.
std::vector<Mark> usual_turn(const std::vector<double> &interval_s, const std::vector<std::size_t> &marks,
                             const std::vector<std::size_t> &ends, std::size_t count) {
    std::map<std::vector<int>, std::size_t> seen;
    for (std::size_t k : ends) ++seen[steps_before(marks, k, count)];
    const auto usual = std::max_element(seen.begin(), seen.end(), [](const auto &a, const auto &b) { return a.second < b.second; })->first;
    std::vector<std::vector<std::size_t>> places(count);
    for (std::size_t k : ends) {
        if (steps_before(marks, k, count) != usual) continue;
        for (std::size_t j = 0; j < count; ++j) places[j].push_back(marks[k + 1 - count + j]);
    }
    std::vector<Mark> turn;
    for (std::size_t j = 0; j < count; ++j) turn.push_back(measured(interval_s, places[j], usual[j]));
    // Alike within noise: the one behind the longest run of teeth.
    const auto widest = std::max_element(turn.begin(), turn.end(), [](const Mark &a, const Mark &b) {
        return std::abs(a.width - b.width) > 0.5 ? a.width < b.width : a.teeth < b.teeth;
    });
    std::rotate(turn.begin(), widest + 1, turn.end());
    return turn;
}

void look_beside(const std::vector<double> &interval_s, const std::vector<std::size_t> &ends, Fit &fit) {
    std::vector<double> before, after, ratio;
    for (std::size_t k : ends) {
        const std::size_t i = fit.marks[k];
        ratio.push_back(interval_s[i] / std::max(interval_s[i - 1], 1e-12));
        // Against the next interval on that side, not the mean around: speed may fall or rise there.
        before.push_back(i >= 2 ? interval_s[i - 1] / std::max(interval_s[i - 2], 1e-12) : 1);
        after.push_back(i + 2 < interval_s.size() ? interval_s[i + 1] / std::max(interval_s[i + 2], 1e-12) : 1);
    }
    fit.before = median(std::move(before)), fit.after = median(std::move(after));
    fit.gap_ratio = median(std::move(ratio));
}

/// Judges the marks as those of a wheel with `count` marks and so many teeth.
Fit judge(const std::vector<double> &interval_s, const std::vector<std::size_t> &marks, std::size_t count, int teeth) {
    Fit fit;
    fit.marks = marks;
    const std::vector<std::size_t> ends = repeats(marks, count, teeth);
    if (ends.empty()) return fit;
    fit.teeth = teeth;
    fit.turn = usual_turn(interval_s, marks, ends, count);
    std::vector<int> steps;
    for (const Mark &mark : fit.turn) steps.push_back(mark.teeth);
    std::size_t run = 0, last = 0;
    for (std::size_t k : ends) {
        run = k == last + 1 ? run + 1 : 1, last = k;
        fit.longest_run = std::max(fit.longest_run, int(run / count));
        if (count == 1 || steps_before(marks, k, count) == steps) fit.turns.push_back(k);
    }
    fit.consistent = int(count == 1 ? ends.size() : fit.turns.size());
    look_beside(interval_s, count == 1 || fit.turns.empty() ? ends : fit.turns, fit);
    fit.explained = double(ends.size()) * teeth / double(count);
    fit.steps = double(ends.size()) / double(marks.size() - count);
    fit.score = fit.explained * believed(fit.before, fit.after);
    return fit;
}

bool is_even(const std::vector<Mark> &turn) {
    return std::all_of(turn.begin(), turn.end(), [&](const Mark &mark) { return mark.teeth == turn.front().teeth; });
}

/// A wheel may have lesser marks that no floor showed: intervals that stand out at the same tooth of nearly every revolution.
Fit with_lesser_marks(const std::vector<double> &interval_s, Fit fit) {
    if (fit.turn.size() != 1 || fit.consistent < kRevolutionsToLook) return fit;
    std::vector<std::size_t> more;
    std::size_t count = 1;
    const double least = std::max(kLesserMark, 1 + kBeyondNoise * roughness(interval_s));
    const auto add = [&](int tooth) {
        ++count;
        for (std::size_t k : fit.turns) more.push_back(fit.marks[k - 1] + std::size_t(tooth));
    };
    for (int tooth = 2; tooth + 1 < fit.teeth; ++tooth) {
        std::vector<double> alone, paired;
        for (std::size_t k : fit.turns) {
            const std::size_t i = fit.marks[k - 1] + std::size_t(tooth);
            alone.push_back(standing_out(interval_s, i));
            paired.push_back(standing_out_together(interval_s, i));
        }
        if (tooth + 2 < fit.teeth && is_usually(paired, fit.teeth < kManyTeeth ? kPairOfFew : kPairOfMany)) {
            add(tooth), add(tooth + 1);
            ++tooth;
        } else if (is_usually(alone, least)) {
            add(tooth);
        }
    }
    if (more.empty() || count > std::size_t(kMarksMax)) return fit;
    std::vector<std::size_t> marks = more;
    for (std::size_t k : fit.turns) marks.push_back(fit.marks[k - 1]), marks.push_back(fit.marks[k]);
    std::sort(marks.begin(), marks.end());
    marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
    Fit finer = judge(interval_s, marks, count, fit.teeth);
    if (is_even(finer.turn)) return fit_marks(interval_s, marks, nullptr); // every second mark had been taken
    return finer.turns.size() + 1 >= fit.turns.size() / 2 && !finer.turns.empty() ? finer : fit;
}

/// Where marks are hard to see, those of every second or third revolution may come out best. Then there are others at even distances.
Fit without_multiples(const std::vector<double> &interval_s, Fit fit) {
    if (fit.turn.size() != 1 || fit.turns.empty()) return fit;
    for (int times = fit.teeth / kTeethMin; times > 1; --times) {
        if (fit.teeth % times) continue;
        const std::size_t part = std::size_t(fit.teeth / times);
        std::vector<double> ratio;
        std::vector<std::size_t> marks;
        for (std::size_t k : fit.turns) {
            for (std::size_t i = fit.marks[k - 1]; i <= fit.marks[k]; i += part) {
                if (i != fit.marks[k - 1] && i != fit.marks[k]) ratio.push_back(standing_out(interval_s, i));
                if (marks.empty() || i > marks.back()) marks.push_back(i);
            }
        }
        if (!is_usually(ratio, kLesserMark)) continue;
        Fit single = judge(interval_s, marks, 1, int(part));
        if (!single.turns.empty()) return single;
    }
    return fit;
}

void add_revolution(const std::vector<double> &interval_s, Fit &fit) {
    if (fit.turns.empty()) return;
    const std::size_t count = fit.turn.size(), first = fit.turns.front();
    std::vector<std::size_t> before, ends, mark;
    for (std::size_t k : fit.turns) before.push_back(fit.marks[k - count]), ends.push_back(fit.marks[k]);
    for (std::size_t j = 1; j <= count; ++j) mark.push_back(fit.marks[first - count + j] - fit.marks[first - count] - 1);
    fit.usual = revolution_of(interval_s, before, ends, mark);
}

/// The numbers of teeth that the distances over `count` marks speak for, the commonest first.
std::vector<int> likely_teeth(const std::vector<std::size_t> &marks, std::size_t count) {
    std::map<int, int> seen;
    for (std::size_t k = count; k < marks.size(); ++k) {
        const std::size_t teeth = marks[k] - marks[k - count];
        if (teeth >= kTeethMin && teeth <= kTeethMax) ++seen[int(teeth)];
    }
    std::vector<std::pair<int, int>> by_edges;
    for (const auto &[teeth, times] : seen) by_edges.push_back({times * teeth, teeth});
    std::sort(by_edges.rbegin(), by_edges.rend());
    std::vector<int> likely;
    for (std::size_t i = 0; i < std::min<std::size_t>(by_edges.size(), 6); ++i) likely.push_back(by_edges[i].second);
    return likely;
}

/// log(interval / mean of its neighbours), within limits.
std::vector<double> prominence(const std::vector<double> &interval_s) {
    std::vector<double> log_ratio(interval_s.size(), 0);
    for (std::size_t i = 1; i + 1 < interval_s.size(); ++i) {
        const double beside = interval_s[i - 1] + interval_s[i + 1];
        if (beside > 0 && interval_s[i] > 0) log_ratio[i] = std::clamp(std::log(2 * interval_s[i] / beside), -1.0, 1.6);
    }
    return log_ratio;
}

/// Numbers of teeth after which the train is most like itself: found under jitter that hides single marks.
std::vector<int> alike_after(const std::vector<double> &log_ratio) {
    const std::size_t size = std::min(log_ratio.size(), kLikenessMax);
    std::vector<std::pair<double, int>> likeness;
    for (int lag = kTeethMin; lag <= kTeethMax && std::size_t(2 * lag) < size; ++lag) {
        double sum = 0;
        for (std::size_t i = 0; i + std::size_t(lag) < size; ++i) sum += log_ratio[i] * log_ratio[i + std::size_t(lag)];
        likeness.push_back({sum / double(size - std::size_t(lag)), lag});
    }
    std::sort(likeness.rbegin(), likeness.rend());
    std::vector<int> lags;
    for (std::size_t i = 0; i < std::min(kLikely, likeness.size()); ++i) lags.push_back(likeness[i].second);
    return lags;
}

/// The most prominent interval of every revolution.
std::vector<std::size_t> peaks(const std::vector<double> &log_ratio, int teeth) {
    std::vector<std::size_t> found;
    const std::size_t half = std::size_t(teeth) / 2, size = log_ratio.size();
    for (std::size_t i = 1; i + 1 < size; ++i) {
        if (log_ratio[i] < kLeastPeak || log_ratio[i] > std::log(kRatioMax)) continue;
        const auto from = log_ratio.begin() + std::ptrdiff_t(i > half ? i - half : 0);
        const auto to = log_ratio.begin() + std::ptrdiff_t(std::min(size, i + half + 1));
        if (std::max_element(from, to) == log_ratio.begin() + std::ptrdiff_t(i)) found.push_back(i);
    }
    return found;
}

} // namespace

std::vector<double> intervals(const std::vector<double> &time_s) {
    std::vector<double> interval_s;
    for (std::size_t i = 1; i < time_s.size(); ++i) interval_s.push_back(time_s[i] - time_s[i - 1]);
    return interval_s;
}

std::vector<std::size_t> find_marks(const std::vector<double> &interval_s, double floor, double most) {
    std::vector<std::size_t> marks;
    for (std::size_t i = 1; i + 1 < interval_s.size(); ++i) {
        const double before = interval_s[i - 1], here = interval_s[i], after = interval_s[i + 1];
        if (before <= 0 || after <= 0) continue; // two edges at one time
        if (here >= floor * std::max(before, after) && here <= most * (before + after) / 2)
            marks.push_back(i);
    }
    return marks;
}

std::vector<std::size_t> find_added_teeth(const std::vector<double> &interval_s) {
    std::vector<std::size_t> marks;
    for (std::size_t i = 1; i + 2 < interval_s.size(); ++i) {
        const double two = interval_s[i] + interval_s[i + 1];
        const double least = std::min(interval_s[i - 1], interval_s[i + 2]), most = std::max(interval_s[i - 1], interval_s[i + 2]);
        if (two > 0.7 * most && two < 1.4 * least && std::max(interval_s[i], interval_s[i + 1]) < 0.7 * least) marks.push_back(i);
    }
    return marks;
}

Fit fit_marks(const std::vector<double> &interval_s, const std::vector<std::size_t> &marks, const Wheel *wheel) {
    Fit best;
    best.marks = marks;
    const std::vector<int> wanted = wheel ? marks_of(*wheel) : std::vector<int>{};
    for (std::size_t count = 1; count <= std::size_t(kMarksMax); ++count) {
        if (wheel && wanted.size() != count) continue;
        for (int teeth : likely_teeth(marks, count)) {
            Fit fit = judge(interval_s, marks, count, teeth);
            if (wheel && !is_turn_of(fit.turn, wanted)) continue;
            if (count > 1 && is_even(fit.turn)) continue; // one mark, seen several times
            const bool more = !best.turn.empty() && best.turn.size() < count;
            // Where every second mark is left over, the wheel has more of them.
            const bool leaves_marks = best.steps < kMostSteps && fit.steps > kNearlyAll;
            if (more ? fit.explained > (leaves_marks ? 1 : kMoreMarks) * best.explained : fit.score > best.score) best = std::move(fit);
        }
    }
    return best;
}

Fit fit_wheel(const std::vector<double> &interval_s, const Wheel *wheel) {
    Fit best;
    const auto consider = [&](const std::vector<std::size_t> &marks, double needed) {
        Fit fit = fit_marks(interval_s, marks, wheel);
        if (fit.score > needed * best.score || best.marks.empty()) best = std::move(fit);
    };
    for (double floor : kFloors) consider(find_marks(interval_s, floor), floor < kFloors[0] ? kMoreMarks : 1);
    consider(find_marks(interval_s, kWideFloor, kWideMax), kMoreMarks);
    const std::vector<double> log_ratio = prominence(interval_s);
    for (int teeth : alike_after(log_ratio)) consider(peaks(log_ratio, teeth), kMoreMarks);
    if (!wheel) best = with_lesser_marks(interval_s, without_multiples(interval_s, std::move(best)));
    add_revolution(interval_s, best);
    return best;
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
