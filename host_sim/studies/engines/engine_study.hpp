// SPDX-License-Identifier: MIT
// Torque on engines that nobody has seen: what is read wrong on drawn engines of own and of other physics (misfire_set.hpp), beside
// the goals. The table of docs/results/engines.md.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace sixdeg {

struct EngineStudy {
    std::string part;         ///< Of engine_study_parts(); empty: all.
    int engines = 10;         ///< Of each physics.
    std::uint64_t seed = 501; ///< Of the first engine; the next ones follow.
    std::string out;          ///< Folder for engines.csv, a row a figure of an engine; empty: none.
};

std::vector<std::string> engine_study_parts();
/// Prints the table. Throws InputError.
void print_engine_study(const EngineStudy &study);

} // namespace sixdeg
