// SPDX-License-Identifier: MIT
// Names for wheels: from the marks that a recording shows to positions and missing teeth, and back. Used by the guess only.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording/marks.hpp"

namespace sixdeg {

/// A wheel that a turn of marks may be, and how far its drawing is from what was measured.
struct WheelName {
    Wheel wheel;
    double doubt; ///< Smaller fits better; in tooth spacings of the marks, less for wheels that are made.
    double sd;    ///< How well the widths of the marks are known, the poorest of them.
    double width; ///< Of the last mark, if the wheel is this one.
};

/// The wheels that have these marks, the likeliest first; empty without a turn, and for one that no wheel has. Positions 12 to 120.
std::vector<WheelName> wheels_of(const Fit &fit);

/// Teeth before each mark of a wheel; of one part of it where the marks repeat within the revolution.
std::vector<int> marks_of(const Wheel &wheel);
/// Whether a turn has these teeth, from whichever mark on.
bool is_turn_of(const std::vector<Mark> &turn, const std::vector<int> &teeth);

/// Wheels of this one several times a revolution that are made: 44-2-2 for 22-2. How many times.
std::vector<int> repeated_as(const Wheel &wheel);
/// The wheel so many times a revolution.
Wheel repeated(const Wheel &wheel, int times);

/// "36-2-1" by its numbers alone, where the marks lie being unknown.
struct WheelText {
    int positions = 0;
    std::vector<int> runs; ///< Missing teeth of each mark, in the order given.
    bool added = false;    ///< "24+1": one tooth more than positions.
};
/// Throws InputError naming `from` for a text that is no wheel.
WheelText parse_wheel_text(const std::string &text, const std::string &from);
/// Whether a wheel has these numbers.
bool is_named(const Wheel &wheel, const WheelText &text);

} // namespace sixdeg
