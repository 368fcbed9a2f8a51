// SPDX-License-Identifier: MIT
#include "io/recording/guess.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/error.hpp"
#include "io/recording/cam.hpp"
#include "io/recording/candidates.hpp"
#include "io/recording/home.hpp"

namespace sixdeg {
namespace {

// What an engine does; the limits are less than a factor of 1000 apart, so only one unit of time fits.
constexpr double kRpmMin = 20, kRpmMax = 19000;
// Beside an added tooth intervals look a little like marks, and so explain nearly as many edges.
constexpr double kAddedShare = 0.8;
// Standard deviations of a mark's width, on either side of the middle between two wheels, within which neither is named.
constexpr double kUnclearSds = 2.5, kUnclear = 0.6, kRare = 0.25;
constexpr int kCoarse = 40; // Positions; on fewer the speed may change much across a mark.
constexpr double kUnits[] = {1, 1e-3, 1e-6, 1e-9};

std::string describe_attempt(const Recording &recording, const Candidate &candidate) {
    const std::size_t edges = candidate.time.size(), marks = candidate.fit.marks.size();
    return fmt::format("{}{}: {} edges, {} gaps, {} of them one revolution apart", column_label(recording, candidate.column),
                       recording.is_edge_times() ? "" : " " + to_string(candidate.edge), edges, marks, candidate.fit.consistent);
}

[[noreturn]] void fail(const Recording &recording, const Constraints &constraints, const std::vector<Candidate> &tried) {
    constexpr std::size_t kShown = 4;
    std::string attempts;
    std::size_t shown = 0;
    for (const Candidate &candidate : tried) {
        if (candidate.time.empty() || candidate.way > 0) continue;
        if (shown++ == kShown) break;
        attempts += (attempts.empty() ? "" : "; ") + describe_attempt(recording, candidate);
    }
    if (attempts.empty()) attempts = "no column has edges";
    const std::string wheel = constraints.wheel          ? wanted_name(constraints)
                              : constraints.engine_wheel ? describe(*constraints.engine_wheel)
                                                         : "toothed";
    throw InputError(recording.path, "",
                     fmt::format("no {} wheel found ({}); too few edges, or say more: --wheel 60-2, "
                                 "--edge falling or rising, --column N, --threshold V",
                                 wheel, attempts));
}

void check_enough(const Recording &recording, const Candidate &candidate, const Wheel &wheel) {
    if (int(candidate.time.size()) > wheel.teeth()) return;
    throw InputError(
        recording.path, column_label(recording, candidate.column),
        fmt::format("has {} edges, too few: one revolution of {} needs {}", candidate.time.size(), describe(wheel), wheel.teeth() + 1));
}

void choose_unit(const Recording &recording, const Constraints &constraints, Guess &found) {
    std::vector<double> interval = intervals(found.time);
    const double turn = interval.empty() ? 0 : median(std::move(interval)) * found.wheel.positions;
    const auto rpm = [&](double unit_s) { return turn > 0 ? 60 / (turn * unit_s) : 0; };
    const auto plausible = [&](double unit_s) { return rpm(unit_s) >= kRpmMin && rpm(unit_s) <= kRpmMax; };
    if (constraints.unit_s) {
        found.unit_s = *constraints.unit_s, found.unit_given = true;
    } else if (recording.layout.time_unit_s > 0) {
        found.unit_s = recording.layout.time_unit_s;
    } else {
        const auto unit = std::find_if(std::begin(kUnits), std::end(kUnits), plausible);
        found.unit_s = unit == std::end(kUnits) ? 1 : *unit;
        found.unit_guessed = found.unit_s != 1;
    }
    found.rpm = rpm(found.unit_s);
}

/// The wheel that the fit speaks for, among those that the caller allows.
Wheel choose_wheel(const Constraints &constraints, const Candidate &best, const std::vector<WheelName> &names) {
    if (const auto wanted = wanted_wheel(constraints); wanted && !best.fit.turn.empty() && constraints.engine_wheel) return *wanted;
    if (constraints.wheel) {
        for (const WheelName &name : names) {
            if (is_named(name.wheel, *constraints.wheel)) return name.wheel;
            for (int times : {2, 3, 4})
                if (name.wheel.positions * times <= 120 && is_named(repeated(name.wheel, times), *constraints.wheel))
                    return repeated(name.wheel, times);
        }
        if (const auto wanted = wanted_wheel(constraints)) return *wanted;
    }
    return names.front().wheel;
}

/// A wheel whose marks may lie several times on the revolution is not guessed: the speed would be a multiple.
void check_repetition(const Recording &recording, const Constraints &constraints, Guess &found, const Fit &fit) {
    if (constraints.wheel || constraints.engine_wheel || found.tooth_added) return;
    const std::vector<int> times = repeated_as(found.wheel);
    if (times.empty()) return;
    std::vector<std::string> names{fmt::format("{} at {:.0f} rpm", describe(found.wheel), found.rpm)};
    for (int count : times) {
        if (const auto cam = guess_cam(recording, found, fit, count, constraints)) {
            found.wheel = repeated(found.wheel, count), found.rpm /= count, found.cam = cam;
            return;
        }
        names.push_back(fmt::format("{} at {:.0f} rpm", describe(repeated(found.wheel, count)), found.rpm / count));
    }
    if (found.cam) return; // one pulse every second mark: there is one mark a revolution
    throw InputError(
        recording.path, column_label(recording, found.column),
        fmt::format("the marks repeat, and nothing tells how often a revolution: {}; say --wheel, or give --engine or a cam signal",
                    fmt::join(names, ", or ")));
}

/// Two wheels with as many teeth, and marks that are known too poorly to choose: refused rather than read wrongly.
void check_clear(const Recording &recording, const Constraints &constraints, const Candidate &best, const std::vector<WheelName> &names) {
    if (constraints.wheel || constraints.engine_wheel || names.size() < 2) return;
    const double sd = std::max(names[0].sd, names[1].sd);
    // Three missing teeth are rare, and a slow stretch at the mark looks like one more.
    const bool is_rare = missing_runs(names[0].wheel).back() == 3, coarse = names[0].wheel.positions < kCoarse;
    if (names[1].doubt - names[0].doubt > std::clamp(kUnclearSds * sd, is_rare ? coarse ? kUnclear : kRare : 0, kUnclear)) return;
    throw InputError(recording.path, column_label(recording, best.column),
                     fmt::format("has a mark of {:.1f} +- {:.1f} spacings in {} revolutions, too little to tell {} from {}; say --wheel",
                                 names[0].width, sd, best.fit.consistent, describe(names[0].wheel), describe(names[1].wheel)));
}

std::string name_runner_up(const Recording &recording, const Candidate &best, const Candidate *other, const Guess &found,
                           const std::vector<WheelName> &names) {
    const std::vector<WheelName> others = other ? wheels_of(other->fit) : std::vector<WheelName>{};
    if (!others.empty()) {
        return fmt::format("{} in {}{}, {} against {} edges explained", describe(others.front().wheel),
                           column_label(recording, other->column), recording.is_edge_times() ? "" : " " + to_string(other->edge),
                           std::lround(other->fit.score), std::lround(best.fit.score));
    }
    for (const WheelName &name : names) {
        if (name.wheel.positions == found.wheel.positions || found.wheel.positions % name.wheel.positions == 0) continue;
        return fmt::format("{}, whose mark would measure {} spacings, not {:.1f}", describe(name.wheel),
                           missing_runs(name.wheel).back() + 1, best.fit.turn.back().width);
    }
    return "";
}

Guess added_tooth_guess(const Candidate &best, const Recording &recording, int positions) {
    Guess found;
    found.tooth_added = true;
    found.wheel = {positions, {positions - 1}};
    found.column = best.column, found.edge = best.edge, found.slicing = best.slicing;
    found.is_edge_times = recording.is_edge_times();
    found.consistent_revolutions = best.added.consistent;
    found.gap_ratio = 0.5;
    return found;
}

void filter_teeth(const Recording &recording, const Constraints &constraints, const Candidate &best, const std::vector<double> &references,
                  Guess &found) {
    AddedTooth filter(found);
    for (double time : references) filter.reference(time);
    for (double time : best.time) filter.edge(time, found.time);
    filter.finish(found.time);
    choose_unit(recording, constraints, found);
}

Guess home_guess(const Recording &recording, const Constraints &constraints, const HomeFound &seen) {
    Guess found = added_tooth_guess(*seen.wheel, recording, seen.positions);
    found.home = seen.home;
    found.consistent_revolutions = seen.turns * (seen.home.on_cam ? 2 : 1);
    found.gap_ratio = 2;
    const std::vector<double> references = edges(recording, seen.home.column, seen.home.edge);
    filter_teeth(recording, constraints, *seen.wheel, references, found);
    if (!seen.home.on_cam) {
        found.runner_up = fmt::format("{0}+1 with the one tooth on a cam, at {1:.0f} rpm: --wheel {0}+1", seen.positions / 2,
                                      2 * found.rpm);
        return found;
    }
    // The single tooth lies in the mark that was made: between the last tooth and the first.
    CamGuess cam;
    cam.column = seen.home.column, cam.edge = seen.home.edge, cam.slicing = seen.home.slicing;
    cam.place_rev = (seen.positions - 2 + (1 + seen.home.between) / 2) / (seen.positions - 1);
    cam.time = references;
    found.cam = cam;
    return found;
}

} // namespace

Guess guess(const Recording &recording, const Constraints &constraints) {
    std::vector<Candidate> tried = candidates(recording, constraints);
    const bool wants_added = constraints.wheel && constraints.wheel->added;
    const bool may_be_added = wants_added || (!constraints.wheel && !constraints.engine_wheel);
    const Candidate *added = may_be_added ? choose_added(tried) : nullptr;
    const Candidate *best = wants_added ? nullptr : choose(recording, constraints, tried);
    if (added && (!best || added->added.explained > kAddedShare * best->fit.explained)) {
        Guess found = added_tooth_guess(*added, recording, added->added.teeth - 1);
        filter_teeth(recording, constraints, *added, {}, found);
        return found;
    }
    const bool clear = best && best->fit.explained > kAddedShare * double(best->time.size());
    if (const auto home = may_be_added && !clear ? find_home(recording, constraints, tried) : std::nullopt)
        return home_guess(recording, constraints, *home);
    if (!best) fail(recording, constraints, tried);
    Guess result;
    const std::vector<WheelName> names = wheels_of(best->fit);
    result.gap_ratio = best->fit.gap_ratio;
    if (names.empty() && !wanted_wheel(constraints)) fail(recording, constraints, tried);
    result.wheel = names.empty() ? *wanted_wheel(constraints) : choose_wheel(constraints, *best, names);
    check_enough(recording, *best, result.wheel);
    result.edge = best->edge;
    result.column = best->column;
    result.slicing = best->slicing;
    result.is_edge_times = recording.is_edge_times();
    result.consistent_revolutions = best->fit.consistent;
    result.time = best->time;
    choose_unit(recording, constraints, result);
    result.weak_tooth = misses_a_tooth(tried, *best);
    if (!names.empty()) {
        check_clear(recording, constraints, *best, names);
        result.runner_up = name_runner_up(recording, *best, runner_up(tried, *best), result, names);
        result.cam = guess_cam(recording, result, best->fit, 1, constraints);
        check_repetition(recording, constraints, result, best->fit);
    }
    return result;
}

std::string wheel_name(const Guess &guess) {
    return guess.tooth_added ? fmt::format("{}+1", guess.wheel.positions) : describe(guess.wheel);
}

std::string describe(const Guess &guess) {
    const std::string gap = guess.home            ? fmt::format("the one tooth in column {}", guess.home->column)
                            : guess.tooth_added   ? "a tooth added"
                            : guess.gap_ratio > 0 ? fmt::format("gap ratio {:.1f}", guess.gap_ratio)
                                                  : "no gap measured";
    return fmt::format("{}, {}, {}", wheel_name(guess), guess.is_edge_times ? "edge times" : to_string(guess.edge), gap);
}

void AddedTooth::edge(double time, std::vector<double> &out) {
    if (!active_) return out.push_back(time);
    held_.push_back(time);
    if (apart_) {
        if (held_.size() > 3) decide(out); // a voltage shows the single tooth somewhat late
        return;
    }
    if (held_.size() < 5) return;
    // Four intervals: the added tooth splits the second of them from the third.
    const std::vector<double> d = intervals(held_);
    if (find_added_teeth(d) == std::vector<std::size_t>{1}) {
        out.push_back(held_[0]);
        out.push_back(held_[1]); // held_[2] is the added tooth, held_[3] the one behind it
        held_.erase(held_.begin(), held_.begin() + 4);
        return;
    }
    out.push_back(held_.front());
    held_.erase(held_.begin());
}

/// Whether the oldest tooth is the last of a revolution. A reference that is off the count by a tooth must be so twice: it may lie so near
/// to a tooth that jitter puts it on either side.
bool AddedTooth::is_last_tooth() {
    bool told = false;
    for (; !references_.empty() && references_.front() < held_[1]; references_.pop_front()) told |= references_.front() >= held_[0];
    if (told) {
        const int off = since_ % positions_ == 1 ? 1 : since_ == positions_ - 1 ? -1 : since_ == positions_ ? 0 : 2;
        const bool follow = !counting_ || off == 0 || off == 2 || off == off_;
        off_ = follow ? 0 : off;
        if (follow) return counting_ = true;
    }
    return counting_ && since_ == positions_;
}

void AddedTooth::decide(std::vector<double> &out) {
    ++since_;
    if (is_last_tooth()) since_ = 0;
    else if (counting_) out.push_back(held_.front());
    held_.erase(held_.begin());
}

void AddedTooth::finish(std::vector<double> &out) {
    while (apart_ && held_.size() > 1) decide(out);
    out.insert(out.end(), held_.begin(), held_.end());
    held_.clear();
}

} // namespace sixdeg
