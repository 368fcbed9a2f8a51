// SPDX-License-Identifier: MIT
// The figures of docs/results/driveline.md. Each part prints a table; nothing is asserted.
#pragma once
#include <string>
#include <vector>

namespace sixdeg {

std::vector<std::string> driveline_study_parts();
/// Prints one part, or every one for an empty name. `seconds` of a drive, where a part drives. `folder`, where not empty, takes Figure 6
/// as figure_6.csv and figure_6_three.csv.
void print_driveline_study(const std::string &part, double seconds, unsigned seed, const std::string &folder);

} // namespace sixdeg
