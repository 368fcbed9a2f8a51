// SPDX-License-Identifier: MIT
// The closed-loop figures of docs/results/afr.md, by its definitions: how the fuel balance does on the simulated engine.
#pragma once
#include <string>
#include <vector>

namespace sixdeg {

/// Names of the tables, in the order in which a whole study prints them.
std::vector<std::string> loop_study_parts();
/// Prints one table, or every one for an empty name, to standard output; nothing is asserted. `seeds` perturbed calibrations (some
/// tables take a share of them, one at least); `tune`: parameters KEY=VALUE over their defaults. Throws InputError for a
/// parameter that does not exist.
void print_loop_study(const std::string &part, int seeds, const std::vector<std::string> &tune);

} // namespace sixdeg
