// SPDX-License-Identifier: MIT
// [exhaust] and [uego] of ENGINE.toml: what plant and calibration both know. Field by field: docs/reference/files.md.
#pragma once
#include <optional>
#include <vector>

#include "common/profile.hpp"
#include "common/toml_file.hpp"

namespace sixdeg {

/// What a test bench's slow instruments read at one steady point; the calibration trims its model to it.
struct ExhaustReading {
    double speed_radps, intake_pa, lambda; ///< lambda of document 004, in the exhaust.
    double air_kg;                         ///< Fresh air of a cylinder and cycle.
    double pressure_pa, kelvin;            ///< In the manifold, means.
};

struct ExhaustSystem {
    double valve_close_rad = 0; ///< After firing TDC.
    double valve_area_m2 = 0;   ///< Largest effective area; times sin^2 over the opening.
    double manifold_m3 = 0;
    Profile turbine_area_m2;    ///< Effective, over engine speed in rad/s.
    double pipe_m3 = 0, mixing_m3 = 0, dead_time_s = 0; ///< Between turbine and sensor.
    double uego_tau_s[2] = {0, 0};
    std::vector<ExhaustReading> readings;
    double flow_factor = 1; ///< On the charge as the calibration believes it; no field of the file.
};

/// None when the file has no [exhaust]. Throws InputError.
std::optional<ExhaustSystem> read_exhaust_system(TomlFile &file);

} // namespace sixdeg
