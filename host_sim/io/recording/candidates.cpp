// SPDX-License-Identifier: MIT
#include "io/recording/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr int kConsistentMin = 2;
constexpr double kShareMin = 0.3; // Of the revolutions that the edges could make; faults break some.
constexpr double kNoisyShareMin = 0.75, kNoisy = 0.1, kRatherNoisy = 0.07; // More where edges are so uneven: chance explains some.
constexpr int kNoisyConsistentMin = 3;
constexpr double kLeastMark = 1.25, kLeastMeasured = 1.5, kWellKnown = 0.15; // Spacings.
// Two intervals over two spacings (least_pair): on the way from an added tooth to none. Speed changes less across many teeth.
constexpr double kPairOfFew = 0.64, kPairOfMany = 0.72;
constexpr int kManyTeeth = 20;
constexpr int kAddedPositions[] = {12, 24, 36}; // Wheels with a tooth added that are made.
constexpr int kRunMin = 5;        // Or so many in a row, wherever they are: chance does not do that.
// A recording contradicts a wheel that it was said to be when another explains so many times as many edges.
constexpr double kContradicts = 1.5;
// Another threshold may show a tooth more, but not a rougher train, nor one with an edge within the mark.
constexpr double kRougher = 1.5, kRoughAnyway = 0.05, kBesideMin = 0.6, kBesideMax = 1.3;

bool is_plausible(const Candidate &candidate, const Fit &fit) {
    if (fit.turn.empty() || fit.consistent < (candidate.roughness > kNoisy ? kNoisyConsistentMin : kConsistentMin)) return false;
    // An incomplete revolution at either end does not count against it.
    const int possible = std::max(1, int(candidate.time.size() - 1) / fit.teeth - 1);
    return fit.consistent >= (candidate.roughness > kNoisy ? kNoisyShareMin : kShareMin) * possible || fit.longest_run >= kRunMin;
}

/// Another threshold on the same signal shows a tooth that was missed.
bool shows_more_teeth(const Candidate &challenger, const Candidate &best) {
    const auto is_tooth = [](double beside) { return beside > kBesideMin && beside < kBesideMax; };
    if (!is_tooth(challenger.fit.before) || !is_tooth(challenger.fit.after)) return false;
    return challenger.column == best.column && challenger.edge == best.edge && challenger.fit.teeth > best.fit.teeth &&
           challenger.fit.consistent >= best.fit.consistent - 1 && challenger.fit.explained > best.fit.explained &&
           challenger.roughness < kRougher * best.roughness + kRoughAnyway;
}

/// More edges in consistent revolutions win; a revolution more or less is chance, then the smoother train wins, and of two ways to
/// slice a signal the usual one.
bool is_better(const Candidate &challenger, const Candidate &best) {
    if (shows_more_teeth(challenger, best)) return true;
    if (shows_more_teeth(best, challenger)) return false;
    const double gain = challenger.fit.score - best.fit.score;
    const double chance = std::max(double(best.fit.teeth), 0.1 * best.fit.score);
    if (std::abs(gain) > chance) return gain > 0;
    if (challenger.column == best.column && challenger.edge == best.edge) return false;
    if (challenger.way > 0 && challenger.column == best.column) return false;
    return challenger.roughness < 0.9 * best.roughness;
}

std::vector<int> columns_to_try(const Recording &recording, const Constraints &constraints) {
    if (constraints.column) {
        column_kind(recording, *constraints.column);
        return {*constraints.column};
    }
    if (recording.is_edge_times()) return {recording.layout.time_column};
    std::vector<int> columns;
    std::size_t bad = 0;
    for (int column = 0; column <= recording.last_column(); ++column) {
        if (!recording.layout.is_signal(std::size_t(column))) continue;
        if (recording.bad_cells[std::size_t(column)].line) bad = std::size_t(column) + 1;
        else if (column != constraints.cam_column || !constraints.cam_file.empty()) columns.push_back(column);
    }
    if (columns.empty() && bad > 0) column_kind(recording, int(bad) - 1); // says which cell it is
    return columns;
}

Candidate judged(int column, Edge edge, const Slicing &slicing, int way, std::vector<double> time) {
    Candidate candidate{column, edge, slicing, way, std::move(time), {}, {}, 0};
    const std::vector<double> interval = intervals(candidate.time);
    candidate.fit = fit_wheel(interval, nullptr);
    candidate.added = fit_marks(interval, find_added_teeth(interval), nullptr);
    candidate.roughness = roughness(interval);
    return candidate;
}

/// Under jitter the intervals beside an added tooth pass for marks.
/// No wheel that is made has as many teeth as one of those and one more.
bool has_added_tooth(const Candidate &candidate) {
    const Fit &fit = candidate.fit;
    const auto *const end = std::end(kAddedPositions);
    const bool as_many = fit.turn.size() == 1 && std::find(std::begin(kAddedPositions), end, fit.teeth - 1) != end;
    if (as_many && candidate.roughness > kRatherNoisy) return true;
    return fit.teeth > kAddedPositions[0] && least_pair(fit.usual) < (fit.teeth < kManyTeeth ? kPairOfFew : kPairOfMany);
}

/// What is as wide as a tooth in most revolutions is no mark; beside its neighbours, or where speed changes much there, beside the speed.
bool has_marks(const Fit &fit) {
    if (std::all_of(fit.turn.begin(), fit.turn.end(), [](const Mark &mark) { return mark.width > kLeastMark; })) return true;
    const std::vector<WheelName> names = wheels_of(fit);
    return fit.turn.size() == 1 && !names.empty() && names.front().sd < kWellKnown && names.front().width > kLeastMeasured;
}

Candidate *best_of(std::vector<Candidate> &tried) {
    Candidate *best = nullptr;
    for (Candidate &candidate : tried) {
        if (!is_plausible(candidate, candidate.fit) || !has_marks(candidate.fit) || has_added_tooth(candidate)) continue;
        if (!best || is_better(candidate, *best)) best = &candidate;
    }
    return best;
}

[[noreturn]] void contradict(const Recording &recording, const Constraints &constraints, const Candidate &best) {
    const bool engine = constraints.engine_wheel && !constraints.wheel;
    const std::vector<WheelName> names = wheels_of(best.fit);
    const std::string shown = names.empty() ? "marks of no wheel" : describe(names.front().wheel);
    throw InputError(recording.path, column_label(recording, best.column),
                     fmt::format("shows {} ({} revolutions, mark of {:.1f} spacings), not the {} of {}",
                                 shown, best.fit.consistent, best.fit.turn.back().width,
                                 wanted_name(constraints), engine ? "the engine file" : "--wheel"));
}

bool has_name(const Candidate &candidate, const WheelText &text) {
    for (const WheelName &name : wheels_of(candidate.fit)) {
        if (is_named(name.wheel, text)) return true;
        for (int times : {2, 3, 4})
            if (is_named(repeated(name.wheel, times), text)) return true;
    }
    return false;
}

/// Of a wheel whose name does not say where its marks lie: the candidates whose marks can be so named.
Candidate *best_named(std::vector<Candidate> &tried, const WheelText &text) {
    Candidate *best = nullptr;
    for (Candidate &candidate : tried) {
        if (!is_plausible(candidate, candidate.fit) || !has_name(candidate, text)) continue;
        if (!best || is_better(candidate, *best)) best = &candidate;
    }
    return best;
}

} // namespace

std::optional<Wheel> wanted_wheel(const Constraints &constraints) {
    if (!constraints.wheel) return constraints.engine_wheel;
    if (constraints.wheel->added || constraints.wheel->runs.size() != 1) return std::nullopt;
    Wheel wheel{constraints.wheel->positions, {}};
    for (int i = constraints.wheel->runs[0]; i > 0; --i) wheel.missing.push_back(wheel.positions - i);
    return wheel;
}

std::string wanted_name(const Constraints &constraints) {
    if (!constraints.wheel) return constraints.engine_wheel ? describe(*constraints.engine_wheel) : "";
    if (constraints.wheel->added) return fmt::format("{}+1", constraints.wheel->positions);
    return fmt::format("{}-{}", constraints.wheel->positions, fmt::join(constraints.wheel->runs, "-"));
}

std::vector<Candidate> candidates(const Recording &recording, const Constraints &constraints) {
    std::vector<Candidate> all;
    if (recording.is_edge_times()) {
        const int column = columns_to_try(recording, constraints).front();
        all.push_back(judged(column, Edge::falling, {}, 0, recording.time));
        return all;
    }
    for (int column : columns_to_try(recording, constraints)) {
        const std::vector<double> &value = recording.columns[std::size_t(column)];
        int way = 0;
        for (const Slicing &slicing : slicings(recording, column, constraints.threshold)) {
            EdgeFinder finder(slicing);
            for (std::size_t i = 0; i < recording.rows(); ++i) finder.row(recording.time[i], value[i]);
            finder.finish();
            if (constraints.edge != Edge::rising) all.push_back(judged(column, Edge::falling, slicing, way, std::move(finder.falling)));
            if (constraints.edge != Edge::falling) all.push_back(judged(column, Edge::rising, slicing, way, std::move(finder.rising)));
            ++way;
        }
    }
    return all;
}

Candidate *choose(const Recording &recording, const Constraints &constraints, std::vector<Candidate> &tried) {
    Candidate *const free = best_of(tried);
    if (!constraints.wheel && !constraints.engine_wheel) return free;
    const auto wheel = wanted_wheel(constraints);
    if (!wheel) {
        Candidate *const named = best_named(tried, *constraints.wheel);
        if (!named && free && !constraints.wheel->added) contradict(recording, constraints, *free);
        return named;
    }
    const std::optional<Candidate> shown = free ? std::optional(*free) : std::nullopt;
    for (Candidate &candidate : tried) candidate.fit = fit_wheel(intervals(candidate.time), &*wheel);
    Candidate *const best = best_of(tried);
    if (shown && shown->fit.explained > kContradicts * (best ? best->fit.explained : 0)) contradict(recording, constraints, *shown);
    // Nothing was left to choose: the caller's word stands, however odd the marks.
    if (!best && tried.size() == 1 && constraints.wheel) return &tried.front();
    return best;
}

const Candidate *choose_added(const std::vector<Candidate> &tried) {
    const Candidate *best = nullptr;
    for (const Candidate &candidate : tried) {
        const auto *const end = std::end(kAddedPositions);
        if (std::find(std::begin(kAddedPositions), end, candidate.added.teeth - 1) == end) continue;
        if (candidate.added.turn.size() != 1 || !is_plausible(candidate, candidate.added)) continue;
        const double gain = best ? candidate.added.explained - best->added.explained : 1;
        if (!best || gain > best->added.teeth || (gain > -best->added.teeth && candidate.roughness < 0.9 * best->roughness))
            best = &candidate;
    }
    return best;
}

bool misses_a_tooth(const std::vector<Candidate> &tried, const Candidate &best) {
    return best.way > 0 && std::any_of(tried.begin(), tried.end(), [&](const Candidate &usual) {
               return usual.way == 0 && usual.column == best.column && usual.edge == best.edge && shows_more_teeth(best, usual);
           });
}

const Candidate *runner_up(const std::vector<Candidate> &tried, const Candidate &best) {
    const Candidate *second = nullptr;
    for (const Candidate &candidate : tried) {
        if (&candidate == &best || !is_plausible(candidate, candidate.fit) || candidate.fit.teeth == best.fit.teeth) continue;
        if (!second || candidate.fit.score > second->fit.score) second = &candidate;
    }
    return second;
}

} // namespace sixdeg
