// SPDX-License-Identifier: MIT
// A wheel without a mark beside a single tooth on another sensor: 24+1. Used by the guess only.
#pragma once
#include "io/recording/candidates.hpp"

namespace sixdeg {

/// An even wheel in one column and its single tooth in another.
struct HomeFound {
    const Candidate *wheel = nullptr;
    HomeTooth home;
    int positions = 0;
    double share = 0; ///< Of the steps from one pulse to the next that have the usual number of teeth.
    int turns = 0;    ///< How many of them.
};

/// The clearest of them, if there is one: teeth from pulse to pulse are those of a wheel that is made (12, 24 or 36), once or twice, or
/// of the one that the caller names.
std::optional<HomeFound> find_home(const Recording &recording, const Constraints &constraints, const std::vector<Candidate> &tried);

} // namespace sixdeg
