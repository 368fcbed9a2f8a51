// SPDX-License-Identifier: MIT
// From a recorded column to the times of its edges.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording/recording.hpp"

namespace sixdeg {

enum class Edge { falling, rising };

std::string to_string(Edge edge);
/// "falling" or "rising". Throws InputError naming `from`.
Edge parse_edge(const std::string &text, const std::string &from);

/// The two levels a signal swings between.
struct Levels {
    double low, high; ///< In the column's unit; a thousandth of the rows lies below low, a thousandth above high.
    double noise;     ///< Median of |second difference| / 2: what the voltage does from row to row without turning.
};

/// Throws InputError when there is no such column.
Levels levels(const Recording &recording, int column);

/// Where a voltage counts as changed.
struct Slicing {
    bool is_level = false;  ///< A logic signal: it changes at the row's time, and nothing is interpolated.
    double threshold = 0;   ///< In the column's unit.
    double band = 0;        ///< Half the dead band: how far the voltage must have left the threshold on either side.
    std::size_t follow = 0; ///< 0: the threshold is fixed. Otherwise it lies half-way within blocks of so many rows, and `band` is
                            ///< the least dead band.
    double folded_from = 0, folded_range = 0; ///< Range above 0: the recorder folds voltages over its top to its bottom.
    std::string name;       ///< How the threshold was found: "half-way", "zero crossing", ...
};

/// The ways to slice a column, the usual one first; `threshold` of the caller leaves one. Empty for a constant column.
std::vector<Slicing> slicings(const Recording &recording, int column, std::optional<double> threshold = {});

/// Finds edges row by row; memory does not grow with their number.
class EdgeFinder {
  public:
    explicit EdgeFinder(const Slicing &slicing) : slicing_(slicing) {}
    /// The next row; a NaN holds the value before. What is found goes to the ends of `rising` and `falling`.
    void row(double time, double value);
    /// After the last row.
    void finish();
    std::vector<double> rising, falling; ///< Times of edges, ascending; the caller may empty them at any time.

  private:
    struct Row {
        double time, value;
    };
    double unfolded(double value);
    void compare(const Row &row, double threshold, double band);
    void block_is_full();
    void run_block(const std::vector<Row> &rows, double from, double to);

    Slicing slicing_;
    enum { unknown, below, above } side_ = unknown;
    bool has_before_ = false, folded_ = false;
    Row before_{0, 0}, raw_{0, 0};
    double before_threshold_ = 0, up_time_ = 0, down_time_ = 0;
    std::vector<Row> block_, waiting_;
    double waiting_from_ = 0, waiting_middle_ = 0, band_ = 0;
    bool has_waiting_ = false;
};

/// Times of a column's edges, ascending, in the recording's unit. Edge times are returned as they are, whatever `edge` says. Empty for
/// a constant column. Throws InputError when there is no such column. Sliced the usual way unless told otherwise.
std::vector<double> edges(const Recording &recording, int column, Edge edge);

} // namespace sixdeg
