// SPDX-License-Identifier: MIT
// Which column, which edge, which wheel: read off the recording itself. How, and what it cannot do:
// docs/recordings.md.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "common/engine_file.hpp"
#include "io/recording/edges.hpp"

namespace sixdeg {

/// What the caller knows already; only the rest is guessed.
struct Constraints {
    std::optional<Wheel> wheel;
    std::optional<Edge> edge;
    std::optional<int> column;
};

/// A column with one pulse every second revolution: it tells the two revolutions of a four-stroke cycle
/// apart.
struct CamGuess {
    int column = 0;
    Edge edge = Edge::rising;
    int tooth = 0;              ///< The crank tooth it follows, 0 = first after the mark.
    std::vector<double> time_s; ///< Its edges, ascending.
};

struct Guess {
    Wheel wheel;
    Edge edge = Edge::falling; ///< Without meaning for a recording of edge times.
    int column = 0;            ///< 0 for a recording of edge times.
    bool is_edge_times = false;
    double gap_ratio = 0; ///< Median of mark interval over the interval before it; 0 if no mark was seen.
    int consistent_revolutions = 0; ///< Marks that follow the mark before them by exactly the wheel's teeth.
    std::vector<double> time_s;     ///< The edges of column and edge, ascending.
    std::optional<CamGuess> cam;    ///< Empty unless it is clear.
};

/// Throws InputError that says what was tried and which options to give when no column shows a wheel, and
/// when the column that the caller asked for does not exist or has not the edges of one revolution.
Guess guess(const Recording &recording, const Constraints &constraints = {});

/// "60-2, falling, gap ratio 3.3".
std::string describe(const Guess &guess);

} // namespace sixdeg
