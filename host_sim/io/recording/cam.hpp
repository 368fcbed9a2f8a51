// SPDX-License-Identifier: MIT
// Looks for the column that tells the two revolutions of a cycle apart. Used by the guess only.
#pragma once
#include "io/recording/guess.hpp"
#include "io/recording/marks.hpp"

namespace sixdeg {

/// The cam column beside the crank's, if one has exactly one pulse every second revolution. Empty for a wheel
/// of several marks, on which a revolution is not from mark to mark.
std::optional<CamGuess> guess_cam(const Recording &recording, const Guess &crank, const Fit &fit);

} // namespace sixdeg
