// SPDX-License-Identifier: MIT
// The usual revolution of a train of edges, and how wide its marks are beside a course of speed that repeats with the revolution. Used
// by the guess only.
#pragma once
#include <vector>

namespace sixdeg {

/// What the intervals of one revolution take, in the median of all. Slots count from the first interval behind the last mark of a turn.
struct Revolution {
    std::vector<double> share;     ///< Of the revolution's time, by slot; about 1 in sum. Empty: not known.
    std::vector<double> sd;        ///< Standard deviation of each, relative to it.
    std::vector<std::size_t> mark; ///< Which slots are marks, ascending; the last slot is one.
};

/// `ends`: the interval of the last mark of each revolution that counts; `before`: that of the last mark of the revolution before it.
Revolution revolution_of(const std::vector<double> &interval_s, const std::vector<std::size_t> &before,
                         const std::vector<std::size_t> &ends, const std::vector<std::size_t> &mark);

/// The shortest two intervals that follow one another, over twice the shorter of those beside them: near 1 on a wheel whose teeth are even
/// but for marks, 0.75 where twelve teeth turn under a ripple of 40 %, 0.5 where a tooth is added. 1 where the revolution is not known.
double least_pair(const Revolution &revolution);

/// A mark as measured against what the speed would make of its place.
struct MeasuredWidth {
    double spacings, sd;
};

/// The widths of all marks if so many teeth are missing at each. The speed is taken to be a Fourier series of the revolution with a trend,
/// fitted to the intervals that are no marks; how strong each order may be follows from the intervals themselves (D. MacKay, Bayesian
/// interpolation, Neural Computation 4, 1992), so that one strong order is no wide mark. Empty: too few; NaN: others are no teeth.
std::vector<MeasuredWidth> widths_of(const Revolution &revolution, const std::vector<int> &missing);

} // namespace sixdeg
