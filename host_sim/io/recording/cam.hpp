// SPDX-License-Identifier: MIT
// Looks for the column that tells the two revolutions of a cycle apart. Used by the guess only.
#pragma once
#include "io/recording/guess.hpp"
#include "io/recording/marks.hpp"

namespace sixdeg {

/// The cam column beside the crank's, if one has an edge at a place of the revolution that it passes without one in every other.
/// `turns`: how many revolutions of the fit make one of the crank; 1 but where marks may repeat. `column`: the caller's choice.
/// `place_rev`: where the engine has its telling edge, which is preferred among several that tell, of the revolution from position 0 on.
std::optional<CamGuess> guess_cam(const Recording &recording, const Guess &crank, const Fit &fit, int turns, std::optional<int> column,
                                   std::optional<double> place_rev = {});

} // namespace sixdeg
