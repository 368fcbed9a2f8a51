// SPDX-License-Identifier: MIT
// Numbers with a fixed count of decimals, for tables of many rows.
#pragma once
#include <string>

namespace sixdeg {

/// Appends `value` with `decimals` digits (0 to 9) behind the point: the text that fmt's and printf's "%.nf" give, at a tenth of
/// their cost. Infinite and NaN are written as fmt writes them.
void append_fixed(std::string &text, double value, int decimals);

} // namespace sixdeg
