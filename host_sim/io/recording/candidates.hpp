// SPDX-License-Identifier: MIT
// Trains of edges that a recording may hold, and which of them is a crank wheel's. Used by the guess only.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording/guess.hpp"

namespace sixdeg {

/// One column, one edge, one threshold.
struct Candidate {
    int column;
    Edge edge;
    Slicing slicing;
    int way;                  ///< Which of the column's slicings; 0 is the usual one.
    std::vector<double> time; ///< In the recording's unit.
    Fit fit;                  ///< Of any wheel.
    Fit added;                ///< Of a wheel with a tooth too many.
    double roughness;
};

std::vector<Candidate> candidates(const Recording &recording, const Constraints &constraints);

/// The best of them that fits what the caller knows; nullptr without one. Throws InputError where the recording clearly shows a wheel
/// other than the engine file's or the caller's. Its fit is replaced by that of the wheel that they name.
Candidate *choose(const Recording &recording, const Constraints &constraints, std::vector<Candidate> &tried);
/// The best whose wheel has a tooth too many, or nullptr.
const Candidate *choose_added(const std::vector<Candidate> &tried);
/// The best that is another wheel than `best`, or nullptr.
const Candidate *runner_up(const std::vector<Candidate> &tried, const Candidate &best);

/// Whether the usual threshold shows the same signal with fewer teeth.
bool misses_a_tooth(const std::vector<Candidate> &tried, const Candidate &best);

/// The wheel that the caller or the engine file names, where its marks are known by the name.
std::optional<Wheel> wanted_wheel(const Constraints &constraints);
std::string wanted_name(const Constraints &constraints);

} // namespace sixdeg
