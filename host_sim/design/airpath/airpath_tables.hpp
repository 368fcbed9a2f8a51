// SPDX-License-Identifier: MIT
// An air path and the design of its observers (tools/airpath/design.py) as the firmware's tables.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "common/air_path.hpp"
extern "C" {
#include "sd_airpath_bank.h"
}

namespace sixdeg {

/// What a design file holds beside the matrices that go into the tables.
struct AirPathDesign {
    sd_airpath_tables_f32_t tables{};
    double sigma_kpa[2] = {1, 2};              ///< Noise of the two pressures that it was made for.
    std::array<double, 2> mean_kpa{}, fault_kpa{}; ///< Of each residual: what the decision expects of a fault, and what one of interest
                                                   ///< leaves.
    std::array<double, 2> sign{};              ///< Of residual 1 at a closing VGT, of residual 2 at an opening EGR valve.
    std::vector<std::array<double, 2>> others_kpa; ///< Residuals that something else than an actuator leaves, up to two, either sign.
    double covariance[2][2] = {{1, 0}, {0, 1}};
    std::string source;                        ///< Where the covariance is from.
};

/// Reads DESIGN.toml. Throws InputError.
AirPathDesign read_air_path_design(TomlFile &file, const AirPathSystem &system, double displaced_m3);
/// The tables of the decision for another covariance of the residuals. Its diagonal is taken: each residual speaks for one actuator
/// alone, so that two faults at once are two sums and no contest of one against the other.
void set_covariance(AirPathDesign &design, const double (&covariance)[2][2]);

} // namespace sixdeg
