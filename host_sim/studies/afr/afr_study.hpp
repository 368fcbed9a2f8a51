// SPDX-License-Identifier: MIT
// The figures of docs/results/afr.md, by its definitions: how the AFR blocks do on the simulated engine, away from the ecu. Each part
// prints one table; nothing is asserted.
#pragma once
#include <string>
#include <vector>

namespace sixdeg {

/// Names of the parts, in the order in which a whole study prints them; `readings` is no part of it.
std::vector<std::string> afr_study_parts();
/// Prints one part, or every one for an empty name. `seeds` of noise for the accuracy, 0: 100; other parts take their share of it,
/// and a part alone its own usual number. `cases`: the first so many operating points of a table that has a line for each, all of them
/// by default.
void print_afr_study(const std::string &part, int seeds, int cases = 1000);

} // namespace sixdeg
