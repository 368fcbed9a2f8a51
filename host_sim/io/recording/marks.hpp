// SPDX-License-Identifier: MIT
// Marks (gaps) in a train of edge times, and how well they fit a wheel. Used by the guess only.
#pragma once
#include <vector>

#include "common/engine_file.hpp"
#include "io/recording/revolution.hpp"

namespace sixdeg {

/// Interval i of a train of edges runs from edge i to edge i + 1.
std::vector<double> intervals(const std::vector<double> &time_s);

/// Indices of the intervals that look like one gap: at least `floor` times as long as the interval on
/// either side, and at most `most` times their mean.
std::vector<std::size_t> find_marks(const std::vector<double> &interval_s, double floor, double most = 4.5);

/// The same where a wheel has a tooth too many: the first of two intervals that together are as long as each of their neighbours.
std::vector<std::size_t> find_added_teeth(const std::vector<double> &interval_s);

/// One mark of a wheel, as the recording shows it.
struct Mark {
    int teeth;    ///< From the mark before it.
    double width; ///< Of the revolutions' medians, in tooth spacings.
    double sd;    ///< How well that is known, from the scatter over the revolutions.
};

/// How one train of edges fits a wheel.
struct Fit {
    std::vector<std::size_t> marks; ///< Interval indices.
    std::vector<Mark> turn;         ///< The marks of one revolution, the widest last; empty without a fit.
    std::vector<std::size_t> turns; ///< Indices into `marks`: the last mark of each consistent revolution.
    int teeth = 0;                  ///< Of one revolution; 0 without a fit.
    int consistent = 0;             ///< Revolutions whose marks follow one another as in the others.
    int longest_run = 0;            ///< How many of those without a break.
    double gap_ratio = 0;           ///< Median of the last mark's interval over the interval before it.
    double steps = 0;               ///< Share of the marks that come so many teeth after those a turn before.
    double explained = 0;           ///< Edges in consistent revolutions.
    double score = 0;               ///< The same, less of that where the gap looks split.
    Revolution usual;                    ///< Of the consistent revolutions; its marks are those of `turn`.
    double before = 1, after = 1;   ///< Medians of the intervals beside the marks over the next ones on their side.
};

/// The best fit; of `wheel` alone where one is given.
Fit fit_wheel(const std::vector<double> &interval_s, const Wheel *wheel);
/// The best fit of these marks.
Fit fit_marks(const std::vector<double> &interval_s, const std::vector<std::size_t> &marks, const Wheel *wheel);

/// Median deviation of an interval from the mean of its neighbours, relative: what tooth errors and noise
/// amount to.
double roughness(const std::vector<double> &interval_s);

double median(std::vector<double> values);

} // namespace sixdeg
