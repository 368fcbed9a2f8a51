// SPDX-License-Identifier: MIT
#include "io/recording/guess.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/error.hpp"
#include "io/recording/cam.hpp"
#include "io/recording/marks.hpp"

namespace sixdeg {
namespace {

constexpr int kConsistentMin = 2;
constexpr double kShareMin = 0.3; // Of the revolutions that the edges could make; faults break some.
constexpr int kRunMin = 5;        // Or so many in a row, wherever they are: chance does not do that.

struct Candidate {
    int column;
    Edge edge;
    std::vector<double> time_s;
    Fit fit;
    double roughness;
};

bool is_plausible(const Candidate &candidate) {
    const Fit &fit = candidate.fit;
    if (fit.consistent < kConsistentMin) return false;
    // An incomplete revolution at either end does not count against it.
    const int possible = std::max(1, int(candidate.time_s.size() - 1) / fit.teeth - 1);
    return fit.consistent >= kShareMin * possible || fit.longest_run >= kRunMin;
}

/// More edges in consistent revolutions win; a revolution more or less is chance, then the smoother train
/// wins.
bool is_better(const Candidate &challenger, const Candidate &best) {
    const double gain = challenger.fit.score - best.fit.score;
    const double chance = std::max(double(best.fit.teeth), 0.1 * best.fit.score);
    if (std::abs(gain) > chance) return gain > 0;
    return challenger.roughness < 0.9 * best.roughness;
}

std::vector<int> columns_to_try(const Recording &recording, const Constraints &constraints) {
    if (constraints.column) {
        column_kind(recording, *constraints.column);
        return {*constraints.column};
    }
    if (recording.is_edge_times()) return {0};
    std::vector<int> columns;
    for (int column = 1; column < int(recording.columns.size()); ++column) columns.push_back(column);
    return columns;
}

std::vector<Edge> edges_to_try(const Recording &recording, const Constraints &constraints) {
    if (constraints.edge) return {*constraints.edge};
    if (recording.is_edge_times()) return {Edge::falling};
    return {Edge::falling, Edge::rising};
}

std::vector<Candidate> candidates(const Recording &recording, const Constraints &constraints) {
    std::vector<Candidate> all;
    for (int column : columns_to_try(recording, constraints)) {
        for (Edge edge : edges_to_try(recording, constraints)) {
            Candidate candidate{column, edge, edges(recording, column, edge), {}, 0};
            const std::vector<double> interval_s = intervals(candidate.time_s);
            candidate.fit = fit_wheel(interval_s, constraints.wheel ? &*constraints.wheel : nullptr);
            candidate.roughness = roughness(interval_s);
            all.push_back(std::move(candidate));
        }
    }
    return all;
}

std::string describe_attempt(const Recording &recording, const Candidate &candidate) {
    const std::size_t edges = candidate.time_s.size(), marks = candidate.fit.marks.size();
    return fmt::format("{}{}: {} edges, {} gaps, {} of them one revolution apart",
                       column_label(recording, candidate.column),
                       recording.is_edge_times() ? "" : " " + to_string(candidate.edge), edges, marks,
                       candidate.fit.consistent);
}

[[noreturn]] void fail(const Recording &recording, const Constraints &constraints,
                       const std::vector<Candidate> &tried) {
    constexpr std::size_t kShown = 4;
    std::string attempts;
    std::size_t shown = 0;
    for (const Candidate &candidate : tried) {
        if (candidate.time_s.empty()) continue;
        if (shown++ == kShown) break;
        attempts += (attempts.empty() ? "" : "; ") + describe_attempt(recording, candidate);
    }
    if (attempts.empty()) attempts = "no column has edges";
    const std::string wheel = constraints.wheel ? describe(*constraints.wheel) : "toothed";
    throw InputError(recording.path, "",
                     fmt::format("no {} wheel found ({}); too few edges, or say more: --wheel 60-2, "
                                 "--edge falling or rising, --column N",
                                 wheel, attempts));
}

/// Nothing was left to choose: the caller's word stands, however odd the marks.
bool is_decided(const Constraints &constraints, const std::vector<Candidate> &tried) {
    return constraints.wheel && tried.size() == 1;
}

const Candidate *choose(const Constraints &constraints, const std::vector<Candidate> &tried) {
    if (is_decided(constraints, tried)) return &tried.front();
    const Candidate *best = nullptr;
    for (const Candidate &candidate : tried) {
        if (is_plausible(candidate) && (!best || is_better(candidate, *best))) best = &candidate;
    }
    return best;
}

void check_enough(const Recording &recording, const Candidate &candidate, const Wheel &wheel) {
    if (int(candidate.time_s.size()) > wheel.teeth()) return;
    throw InputError(recording.path, column_label(recording, candidate.column),
                     fmt::format("has {} edges, too few: one revolution of {} needs {}",
                                 candidate.time_s.size(), describe(wheel), wheel.teeth() + 1));
}

} // namespace

Guess guess(const Recording &recording, const Constraints &constraints) {
    const std::vector<Candidate> tried = candidates(recording, constraints);
    const Candidate *best = choose(constraints, tried);
    if (!best) fail(recording, constraints, tried);
    Guess result;
    result.gap_ratio = best->fit.gap_ratio;
    result.wheel = constraints.wheel ? *constraints.wheel : wheel_of(best->fit.teeth, result.gap_ratio);
    check_enough(recording, *best, result.wheel);
    result.edge = best->edge;
    result.column = best->column;
    result.is_edge_times = recording.is_edge_times();
    result.consistent_revolutions = best->fit.consistent;
    result.time_s = best->time_s;
    result.cam = guess_cam(recording, result, best->fit);
    return result;
}

std::string describe(const Guess &guess) {
    return fmt::format(
        "{}, {}, {}", describe(guess.wheel), guess.is_edge_times ? "edge times" : to_string(guess.edge),
        guess.gap_ratio > 0 ? fmt::format("gap ratio {:.1f}", guess.gap_ratio) : "no gap measured");
}

} // namespace sixdeg
