// SPDX-License-Identifier: MIT
// From a recorded column to the times of its edges.
#pragma once
#include <string>
#include <vector>

#include "io/recording/recording.hpp"

namespace sixdeg {

enum class Edge { falling, rising };

std::string to_string(Edge edge);
/// "falling" or "rising". Throws InputError naming `from`.
Edge parse_edge(const std::string &text, const std::string &from);

/// The two levels a signal swings between, and the band it must cross before an edge counts.
struct Levels {
    double low,
        high; ///< In the column's unit; a thousandth of the rows lies below low, a thousandth above high.

    double threshold() const { return (low + high) / 2; }
    /// Half the dead band. Wide enough for noise, narrow enough for the small swing of a variable-reluctance
    /// sensor at cranking speed in a recording that ends at idle.
    double hysteresis() const { return 0.06 * (high - low); }
};

/// Throws InputError when there is no such column.
Levels levels(const Recording &recording, int column);

/// Times in s of the column's edges, ascending. A level column changes at the row's time. A sampled voltage
/// changes where the straight line between two rows crosses the threshold, once it has also left the dead
/// band; for a variable-reluctance sensor that is its zero crossing. Edge times are returned as they are,
/// whatever `edge` says. Empty for a constant column. Throws InputError when there is no such column.
std::vector<double> edges(const Recording &recording, int column, Edge edge);

} // namespace sixdeg
