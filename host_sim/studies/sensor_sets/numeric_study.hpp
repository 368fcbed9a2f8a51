// SPDX-License-Identifier: MIT
// The ranked sets once more with numbers: floating-point index at every operating point, how much it hangs on
// tolerance and units, and the Kalman filter's standard deviation.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "studies/sensor_sets/linear_point.hpp"
#include "studies/sensor_sets/numeric_index.hpp"
#include "studies/sensor_sets/ranking.hpp"

namespace sixdeg {

/// What the study uses unless it varies them.
constexpr Scaling reference_scaling = Scaling::rows;
constexpr double reference_tolerance = 1e-12;
constexpr double most_studied_sets = 10000; ///< More would take minutes.

/// Numeric against generic index of all sets at one point, one scaling and one tolerance.
struct Comparison {
    std::size_t point;
    Scaling scaling;
    double tolerance;
    std::map<int, int> histogram;
    int agree = 0; ///< Sets with the generic index of the point's regime.
};

struct StudiedSet {
    std::vector<int> index;    ///< By point, reference scaling and tolerance.
    std::vector<double> sigma; ///< By target: root mean square over the points, SI units.
    double relative_sigma;     ///< Root mean square over the targets of sigma / scale.
};

struct NumericStudy {
    std::vector<Comparison> points;      ///< The reference, by point.
    std::vector<Comparison> sensitivity; ///< First point of each regime, every scaling and tolerance.
    std::vector<double> tolerances;      ///< Those of `sensitivity` and `published`.
    /// Index of each published set at the first point of each regime: [regime's turn][set][tolerance],
    /// reference scaling.
    std::vector<std::vector<std::vector<int>>> published;
    std::vector<StudiedSet> sets; ///< In the order of the ranking.
};

NumericStudy study(const SensorModel &model, const NumericModel &numeric, const Ranking &ranking,
                   const std::vector<int> &targets);

const char *name_of(Scaling scaling);

} // namespace sixdeg
