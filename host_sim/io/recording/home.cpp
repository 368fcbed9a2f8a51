// SPDX-License-Identifier: MIT
#include "io/recording/home.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace sixdeg {
namespace {

constexpr int kMade[] = {12, 24, 36};
constexpr int kPulsesMin = 3;
constexpr double kShareMin = 0.8;
constexpr double kRoughMost = 0.25; // Of an even wheel's intervals under jitter of 10 %.

/// Positions of the wheel for so many teeth from pulse to pulse, and on which shaft the single tooth sits; 0: none.
int positions_for(int teeth, const Constraints &constraints, bool &on_cam) {
    if (constraints.wheel) {
        on_cam = teeth == 2 * constraints.wheel->positions;
        return on_cam || teeth == constraints.wheel->positions ? constraints.wheel->positions : 0;
    }
    on_cam = false;
    if (std::find(std::begin(kMade), std::end(kMade), teeth) != std::end(kMade)) return teeth;
    on_cam = teeth % 2 == 0 && std::find(std::begin(kMade), std::end(kMade), teeth / 2) != std::end(kMade);
    return on_cam ? teeth / 2 : 0;
}

/// How the pulses lie among the teeth.
struct Beside {
    int teeth = 0, turns = 0; ///< From pulse to pulse, and how often.
    double share = 0;
    double central = 0; ///< Median distance from the nearer tooth, 0 to 0.5 of the way between two.
    double between = 0; ///< Median place between them.
};

Beside lie(const std::vector<double> &teeth, const std::vector<double> &pulses) {
    std::vector<double> place, central;
    std::vector<std::ptrdiff_t> at;
    for (double pulse : pulses) {
        const auto after = std::upper_bound(teeth.begin(), teeth.end(), pulse);
        if (after == teeth.begin() || after == teeth.end()) continue;
        at.push_back(after - teeth.begin());
        place.push_back((pulse - *(after - 1)) / std::max(*after - *(after - 1), 1e-12));
        central.push_back(std::min(place.back(), 1 - place.back()));
    }
    Beside found;
    if (at.size() < 2) return found;
    std::map<int, int> steps;
    for (std::size_t i = 1; i < at.size(); ++i) ++steps[int(at[i] - at[i - 1])];
    const auto usual = std::max_element(steps.begin(), steps.end(), [](const auto &a, const auto &b) { return a.second < b.second; });
    found.teeth = usual->first, found.turns = usual->second;
    found.share = double(found.turns) / double(at.size() - 1);
    found.central = median(std::move(central)), found.between = median(std::move(place));
    return found;
}

} // namespace

std::optional<HomeFound> find_home(const Recording &recording, const Constraints &constraints, const std::vector<Candidate> &tried) {
    std::optional<HomeFound> best;
    double best_central = 0;
    if (recording.is_edge_times()) return best;
    for (int column = 0; column <= recording.last_column(); ++column) {
        const auto at = std::size_t(column);
        if (column == constraints.column || !recording.layout.is_signal(at) || recording.bad_cells[at].line) continue;
        const auto ways = slicings(recording, column);
        if (ways.empty()) continue;
        EdgeFinder finder(ways.front());
        for (std::size_t i = 0; i < recording.rows(); ++i) finder.row(recording.time[i], recording.columns[std::size_t(column)][i]);
        finder.finish();
        for (const Candidate &wheel : tried) {
            if (wheel.column == column || wheel.way > 0 || wheel.time.size() < 24 || wheel.roughness > kRoughMost) continue;
            for (Edge edge : {Edge::rising, Edge::falling}) {
                const Beside beside = lie(wheel.time, edge == Edge::rising ? finder.rising : finder.falling);
                HomeFound found{&wheel, {column, edge, ways.front(), false, beside.between}, 0, beside.share, beside.turns};
                found.positions = positions_for(beside.teeth, constraints, found.home.on_cam);
                if (found.positions == 0 || beside.turns < kPulsesMin || beside.share < kShareMin) continue;
                // The smoother edge of the teeth, and the edge of the single tooth that lies more clearly between two of them.
                const bool smoother = best && wheel.roughness < 0.9 * best->wheel->roughness;
                const bool rougher = best && wheel.roughness > 1.1 * best->wheel->roughness;
                if (best && !smoother && (rougher || beside.central <= best_central)) continue;
                best = found, best_central = beside.central;
            }
        }
    }
    return best;
}

} // namespace sixdeg
