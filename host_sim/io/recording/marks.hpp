// SPDX-License-Identifier: MIT
// Marks (gaps) in a train of edge times, and how well they fit a wheel. Used by the guess only.
#pragma once
#include <vector>

#include "common/engine_file.hpp"

namespace sixdeg {

/// Interval i of a train of edges runs from edge i to edge i + 1.
std::vector<double> intervals(const std::vector<double> &time_s);

/// Indices of the intervals that look like one gap: at least `floor` times as long as the interval on
/// either side, and at most 4.5 times their mean.
std::vector<std::size_t> find_marks(const std::vector<double> &interval_s, double floor);

/// How one train of edges fits a wheel.
struct Fit {
    std::vector<std::size_t> marks; ///< Interval indices, as find_marks gives them.
    int teeth = 0;        ///< Teeth from one mark to the next that the marks speak for; 0 without any.
    int consistent = 0;   ///< How many marks follow the mark before them by exactly that many teeth.
    int longest_run = 0;  ///< How many of those without a break.
    double gap_ratio = 0; ///< Median over those marks of mark interval over the interval before it.
    double score = 0;     ///< Edges in consistent revolutions, a third of that where the gap looks split.
};

/// The best fit over the marks' floors; teeth allowed: those of `wheel`, or any of a 12 to 120 position
/// wheel.
Fit fit_wheel(const std::vector<double> &interval_s, const Wheel *wheel);

/// The wheel that has so many teeth between marks: a common one if there is one, else what the ratio says.
Wheel wheel_of(int teeth, double gap_ratio);

/// Median deviation of an interval from the mean of its neighbours, relative: what tooth errors and noise
/// amount to.
double roughness(const std::vector<double> &interval_s);

double median(std::vector<double> values);

} // namespace sixdeg
