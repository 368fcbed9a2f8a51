// SPDX-License-Identifier: MIT
#include "io/recording/cam.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

// Of the steps from one cam edge to the next, and of the cycles that the crank shows.
constexpr double kShareMin = 0.8;
// From cycle to cycle a cam edge wanders by belt, chain and phaser, not by a tooth of the coarsest wheel.
constexpr double kStepTolerance_rev = 0.1;
// Two teeth of a cam whose places in the revolution are nearer than this cannot be told apart.
constexpr double kApart_rev = 0.12;
constexpr std::size_t kTeethMax = 6;

/// Place in the cycle at any time inside the revolutions that are consistent.
class Phase {
  public:
    Phase(const Guess &crank, const Fit &fit, int turns) : crank_(crank), teeth_(std::size_t(fit.teeth)), turns_(turns) {
        for (std::size_t k : fit.turns) first_tooth_.push_back(fit.marks[k - fit.turn.size()] + 1);
    }

    int revolutions() const { return int(first_tooth_.size()) / turns_; }

    /// Revolutions since the first mark, each divided evenly over its teeth, the gap being the last of them;
    /// nothing outside the consistent revolutions.
    std::optional<double> at(double time) const {
        const auto &edge = crank_.time;
        const auto after = std::upper_bound(edge.begin(), edge.end(), time);
        if (after == edge.begin() || after == edge.end()) return {};
        const std::size_t here = std::size_t(after - edge.begin()) - 1;
        const auto next = std::upper_bound(first_tooth_.begin(), first_tooth_.end(), here);
        if (next == first_tooth_.begin()) return {};
        const std::size_t tooth = here - *(next - 1);
        if (tooth >= teeth_) return {};
        const double inside = (time - edge[here]) / (edge[here + 1] - edge[here]);
        const double revolution = std::round(double(*(next - 1) - first_tooth_.front()) / double(teeth_));
        return (revolution + (double(tooth) + inside) / double(teeth_)) / turns_;
    }

  private:
    const Guess &crank_;
    std::size_t teeth_;
    int turns_;
    std::vector<std::size_t> first_tooth_; ///< Edge index of the first tooth of each consistent revolution.
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

/// Cam edges at about one place of the revolution.
struct Place {
    double rev;                ///< [0, 1).
    std::vector<double> turned; ///< Revolutions at each edge.
    double spread_rev;         ///< Median distance from their median.
    double range_rev;          ///< Within which nearly all lie.
};

double circular_distance(double a, double b) { return std::abs(std::remainder(a - b, 1.0)); }

/// Sorts edges by their place in the revolution. A moving cam drags its places along, so each edge is compared with the last of a place.
std::vector<Place> places_of(const std::vector<double> &turned) {
    std::vector<Place> places;
    for (double rev : turned) {
        const double in = rev - std::floor(rev);
        Place *nearest = nullptr;
        for (Place &place : places) {
            const double last = place.turned.back() - std::floor(place.turned.back());
            if (circular_distance(in, last) < kApart_rev / 2 &&
                (!nearest || circular_distance(in, last) < circular_distance(in, nearest->rev)))
                nearest = &place;
        }
        if (!nearest) nearest = &places.emplace_back(Place{in, {}, 0, 0});
        nearest->turned.push_back(rev);
    }
    for (Place &place : places) {
        // Around the first edge, so that a place near the mark does not split over both ends of the revolution.
        std::vector<double> off;
        for (double rev : place.turned) off.push_back(std::remainder(rev - place.turned.front(), 1.0));
        const double middle = median(off), rev = place.turned.front() + middle;
        place.rev = rev - std::floor(rev);
        std::sort(off.begin(), off.end());
        place.range_rev = off[off.size() - 1 - off.size() / 20] - off[off.size() / 20];
        for (double &o : off) o = std::abs(o - middle);
        place.spread_rev = median(off);
    }
    return places;
}

/// One edge every second revolution, in nearly all cycles.
bool tells_phase(const Place &place, int revolutions) {
    const std::vector<double> &turned = place.turned;
    if (turned.size() < 2 || double(turned.size()) < kShareMin * revolutions / 2) return false;
    std::size_t regular = 0;
    for (std::size_t i = 1; i < turned.size(); ++i) regular += std::abs(turned[i] - turned[i - 1] - 2) < kStepTolerance_rev;
    return double(regular) >= kShareMin * double(turned.size() - 1);
}

struct Candidate {
    CamGuess cam;
    double spread_rev;
    bool named = false; ///< Where the engine has its telling edge.

    bool is_better_than(const Candidate &other) const { return named != other.named ? named : spread_rev < 0.5 * other.spread_rev; }
};

/// A place of the revolution, as angle, where its teeth are counted evenly.
double by_teeth(const Wheel &wheel, double place_rev) {
    const double position = place_rev * wheel.positions;
    const auto missing = std::lower_bound(wheel.missing.begin(), wheel.missing.end(), position) - wheel.missing.begin();
    return std::min((position - double(missing)) / wheel.teeth(), 1.0);
}

std::optional<Candidate> candidate(const CamGuess &edges, const Phase &phase, std::optional<double> place_rev) {
    Candidate found{edges, 0, false};
    std::vector<double> turned;
    for (double time : found.cam.time) {
        if (const auto rev = phase.at(time)) turned.push_back(*rev);
    }
    std::vector<Place> places = places_of(turned);
    // A stray edge now and then makes a place of its own.
    places.erase(std::remove_if(places.begin(), places.end(),
                                [&](const Place &p) { return double(p.turned.size()) < 0.2 * phase.revolutions() / 2; }),
                 places.end());
    if (places.size() > kTeethMax) return {};
    const Place *best = nullptr;
    for (const Place &place : places) {
        bool alone = tells_phase(place, phase.revolutions());
        for (const Place &other : places) alone &= &other == &place || circular_distance(other.rev, place.rev) > kApart_rev;
        if (!alone) continue;
        const bool named = place_rev && circular_distance(place.rev, *place_rev) < kApart_rev / 2;
        if (!best || named || place.spread_rev < 0.8 * best->spread_rev) best = &place;
        found.named |= named;
        if (named) break;
    }
    if (!best) return {};
    double per_cycle = 0;
    for (const Place &place : places) per_cycle += 2.0 * double(place.turned.size()) / std::max(1, phase.revolutions());
    found.cam.teeth = std::max(1, int(std::lround(per_cycle)));
    found.cam.place_rev = best->rev;
    found.cam.moved_rev = best->range_rev;
    found.spread_rev = best->spread_rev;
    return found;
}

/// A recording that may hold the cam, and its clock beside the crank's: time there * scale + shift.
struct Source {
    const Recording &recording;
    double scale = 1, shift = 0;
};

class Search {
  public:
    Search(const Guess &crank, const Fit &fit, int turns, std::optional<double> place_rev)
        : phase_(crank, fit, turns), place_rev_(place_rev ? std::optional(by_teeth(crank.wheel, *place_rev)) : std::nullopt) {}

    /// Both edges of a column; `like` says where they are from.
    void try_column(const Source &source, int column, CamGuess like) {
        const Recording &recording = source.recording;
        like.column = column;
        like.is_edge_times = column_kind(recording, column) == ColumnKind::edge_times;
        if (like.is_edge_times) return consider(source, like, recording.time);
        const auto ways = slicings(recording, column);
        if (ways.empty()) return;
        like.slicing = ways.front();
        EdgeFinder finder(like.slicing);
        for (std::size_t i = 0; i < recording.rows(); ++i) finder.row(recording.time[i], recording.columns[std::size_t(column)][i]);
        finder.finish();
        for (Edge edge : {Edge::rising, Edge::falling}) {
            like.edge = edge;
            consider(source, like, edge == Edge::rising ? finder.rising : finder.falling);
        }
    }

    /// All columns that may be a cam's, or the one that is wanted.
    void try_columns(const Source &source, std::optional<int> wanted, std::optional<int> except, const CamGuess &like) {
        const Recording &recording = source.recording;
        if (recording.is_edge_times()) return try_column(source, recording.layout.time_column, like);
        for (int column = 0; column <= recording.last_column(); ++column) {
            if (column == except || !recording.layout.is_signal(std::size_t(column)) || recording.bad_cells[std::size_t(column)].line)
                continue;
            if (wanted ? column == *wanted : is_two_level(recording, column)) try_column(source, column, like);
        }
    }

    std::optional<Candidate> best;

  private:
    void consider(const Source &source, CamGuess edges, const std::vector<double> &times) {
        for (double time : times) edges.time.push_back(time * source.scale + source.shift);
        auto found = candidate(edges, phase_, place_rev_);
        if (found && (!best || found->is_better_than(*best))) best = std::move(found);
    }

    Phase phase_;
    std::optional<double> place_rev_;
};

constexpr std::size_t kStretchCells = std::size_t(3) << 20;

/// The stretches of another file that lie beside the crank's edges. Where its header names no unit of time, the recording's is tried
/// first and then the second.
void try_other_file(const Recording &recording, const Guess &crank, const Constraints &constraints, Search &search) {
    RowReader reader{std::filesystem::path(constraints.cam_file)};
    const double stated = reader.layout().time_unit_s;
    CamGuess like;
    like.file = constraints.cam_file;
    while (!search.best) {
        const Recording stretch = read_stretch(reader, kStretchCells);
        if (stretch.rows() == 0) return;
        for (double unit_s : {stated > 0 ? stated : crank.unit_s, stated > 0 ? stated : 1.0}) {
            like.unit_s = unit_s;
            const double shift = stretch.origin.value() * unit_s / crank.unit_s - recording.origin.value();
            search.try_columns({stretch, unit_s / crank.unit_s, shift}, constraints.cam_column, {}, like);
            if (search.best) return;
        }
    }
}

} // namespace

std::optional<CamGuess> guess_cam(const Recording &recording, const Guess &crank, const Fit &fit, int turns,
                                  const Constraints &constraints) {
    const bool elsewhere = !constraints.cam_file.empty();
    if ((recording.is_edge_times() && !elsewhere) || fit.consistent < 4 * turns || fit.turns.empty()) return {};
    Search search(crank, fit, turns, constraints.cam_place_rev);
    if (elsewhere) try_other_file(recording, crank, constraints, search);
    else search.try_columns({recording}, constraints.cam_column, crank.column, {});
    if (!search.best) return {};
    return std::move(search.best->cam);
}

} // namespace sixdeg
