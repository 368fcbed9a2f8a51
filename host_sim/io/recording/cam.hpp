// SPDX-License-Identifier: MIT
// Looks for the column that tells the two revolutions of a cycle apart. Used by the guess only.
#pragma once
#include "io/recording/guess.hpp"
#include "io/recording/marks.hpp"

namespace sixdeg {

/// The cam column beside the crank's or in the caller's other file, if one has an edge at a place of the revolution that it passes
/// without one in every other. `turns`: how many revolutions of the fit make one of the crank; 1 but where marks may repeat. The
/// caller's `cam_column`, `cam_file` and `cam_place_rev` count; an edge at that place is preferred among several that tell.
/// Throws InputError where the other file cannot be read.
std::optional<CamGuess> guess_cam(const Recording &recording, const Guess &crank, const Fit &fit, int turns,
                                  const Constraints &constraints);

} // namespace sixdeg
