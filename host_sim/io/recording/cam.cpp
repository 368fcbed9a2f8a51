// SPDX-License-Identifier: MIT
#include "io/recording/cam.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

// Of the steps from one cam edge to the next, and of the cycles that the crank shows.
constexpr double kShareMin = 0.8;
// A cam edge wanders by belt and chain, not by a tooth of the coarsest wheel.
constexpr double kStepTolerance_rev = 0.1;

/// Place in the cycle at any time inside the revolutions that are consistent.
class Phase {
  public:
    Phase(const Guess &crank, const Fit &fit) : crank_(crank), teeth_(std::size_t(fit.teeth)) {
        for (std::size_t k = 1; k < fit.marks.size(); ++k) {
            if (fit.marks[k] - fit.marks[k - 1] == teeth_) first_tooth_.push_back(fit.marks[k - 1] + 1);
        }
    }

    int revolutions() const { return int(first_tooth_.size()); }

    /// Revolutions since the first mark, each divided evenly over its teeth, the gap being the last of them;
    /// nothing outside the consistent revolutions.
    std::optional<double> at(double t_s) const {
        const auto &edge_s = crank_.time_s;
        const auto after = std::upper_bound(edge_s.begin(), edge_s.end(), t_s);
        if (after == edge_s.begin() || after == edge_s.end()) return {};
        const std::size_t edge = std::size_t(after - edge_s.begin()) - 1;
        const auto next = std::upper_bound(first_tooth_.begin(), first_tooth_.end(), edge);
        if (next == first_tooth_.begin()) return {};
        const std::size_t tooth = edge - *(next - 1);
        if (tooth >= teeth_) return {};
        const double inside = (t_s - edge_s[edge]) / (edge_s[edge + 1] - edge_s[edge]);
        const double revolution = std::round(double(*(next - 1) - first_tooth_.front()) / double(teeth_));
        return revolution + (double(tooth) + inside) / double(teeth_);
    }

  private:
    const Guess &crank_;
    std::size_t teeth_;
    std::vector<std::size_t> first_tooth_; ///< Edge index of tooth 0 of each consistent revolution.
};

/// A logic signal, or a voltage that is nearly always at one of two levels. A pressure, which also has one
/// pulse a cycle, spends as long on its way up and down as at the top.
bool is_two_level(const Recording &recording, int column) {
    const ColumnKind kind = column_kind(recording, column);
    if (kind != ColumnKind::sampled) return kind == ColumnKind::level;
    const Levels swing = levels(recording, column);
    const double span = swing.high - swing.low;
    long low = 0, between = 0, high = 0;
    for (double value : recording.columns[std::size_t(column)]) {
        const double share = (value - swing.low) / span;
        ++(share < 0.3 ? low : share > 0.7 ? high : between);
    }
    return double(between) < 0.3 * double(std::min(low, high));
}

struct Candidate {
    CamGuess cam;
    double spread_rev; ///< Median distance of its edges from their median place in the cycle.
};

std::optional<Candidate> candidate(const Recording &recording, int column, Edge edge, const Phase &phase,
                                   int teeth) {
    Candidate found{{column, edge, 0, edges(recording, column, edge)}, 0};
    std::vector<double> place_rev, in_revolution;
    for (double t_s : found.cam.time_s) {
        if (const auto rev = phase.at(t_s)) place_rev.push_back(*rev);
    }
    if (place_rev.size() < 2 || double(place_rev.size()) < kShareMin * phase.revolutions() / 2) return {};
    std::size_t regular = 0;
    for (std::size_t i = 1; i < place_rev.size(); ++i) {
        if (std::abs(place_rev[i] - place_rev[i - 1] - 2) < kStepTolerance_rev) ++regular;
    }
    if (double(regular) < kShareMin * double(place_rev.size() - 1)) return {};
    // Around the first edge, so that a place near the mark does not split over both ends of the revolution.
    for (double rev : place_rev) in_revolution.push_back(std::remainder(rev - place_rev.front(), 1.0));
    const double middle = median(in_revolution);
    for (double &rev : in_revolution) rev = std::abs(rev - middle);
    found.spread_rev = median(in_revolution);
    const double place = place_rev.front() + middle;
    found.cam.tooth = int((place - std::floor(place)) * teeth);
    return found;
}

} // namespace

std::optional<CamGuess> guess_cam(const Recording &recording, const Guess &crank, const Fit &fit) {
    if (recording.is_edge_times() || fit.consistent < 4 || fit.teeth != crank.wheel.teeth()) return {};
    const Phase phase(crank, fit);
    std::optional<Candidate> best;
    for (int column = 1; column < int(recording.columns.size()); ++column) {
        if (column == crank.column || !is_two_level(recording, column)) continue;
        for (Edge edge : {Edge::rising, Edge::falling}) {
            auto found = candidate(recording, column, edge, phase, fit.teeth);
            if (found && (!best || found->spread_rev < 0.5 * best->spread_rev)) best = std::move(found);
        }
    }
    if (!best) return {};
    return std::move(best->cam);
}

} // namespace sixdeg
