// SPDX-License-Identifier: MIT
// The figures of docs/results/airpath.md. Each part prints a table; nothing is asserted.
#pragma once
#include <string>
#include <vector>

namespace sixdeg {

struct AirPathStudy {
    std::string part;   ///< Empty: every one but residuals, full and fit.
    std::string folder; ///< Takes residuals.csv.
    std::string air_path, design; ///< Files with an [airpath], and DESIGN.toml, in place of the matched ones.
    int runs = 2000;    ///< For each fault.
    double hours = 20;  ///< Of healthy running.
    unsigned seed = 1;
};
std::vector<std::string> air_path_study_parts();
void print_air_path_study(const AirPathStudy &study);

} // namespace sixdeg
