// SPDX-License-Identifier: MIT
// Six detectors of misfires on the made set, at their own limits and at equal false alarms: the table of docs/results/misfire-study.md.
#pragma once
#include <string>
#include <vector>

namespace sixdeg {

struct MisfireStudy {
    std::string part;                ///< One kind of engine alone; empty: all three.
    int engines = 10;                ///< For each kind and physics.
    int cycles = 600;                ///< Of each run.
    std::uint64_t seed = 1;          ///< Of the first engine.
    int rpm = 0;                     ///< Of all points only those of this speed; 0: all.
    double bar = 0;                  ///< The same of the load.
    std::string out;                 ///< Folder for cells.csv and curves.csv; empty: none.
    std::string write;               ///< Folder for the set itself; empty: none.
    std::vector<std::string> set;    ///< Changes of the tune, KEY=VALUE.
};

std::vector<std::string> misfire_study_parts();
/// Prints the tables. Throws InputError.
void print_misfire_study(const MisfireStudy &study);

} // namespace sixdeg
