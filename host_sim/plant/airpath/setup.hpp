// SPDX-License-Identifier: MIT
// [airpath] of SCENARIO.toml: commands of valve and vanes, what the sensors add, how far the engine is from what the ecu
// believes, and faults. Field by field: docs/theory/airpath.md.
#pragma once
#include <optional>
#include <vector>

#include "common/profile.hpp"
#include "common/random.hpp"
#include "plant/airpath/faults.hpp"
#include "plant/airpath/full_data.hpp"

namespace sixdeg::airpath {

/// The engine's own values over those of its file, and what meters read over the truth; 1 as in the file.
struct Errors {
    double filling = 1, egr_area = 1, turbine_area = 1, intake_volume = 1, exhaust_volume = 1;
    double air_flow = 1, intake_pressure = 1, exhaust_pressure = 1;

    /// The data of an engine that is off by so much.
    FullData applied(FullData data) const;
};

/// Each value drawn anew, any within 1 +- share being as likely.
Errors draw_errors(double share, RandomStream random);

struct Setup {
    Profile egr, vgt;   ///< Commands over time, 0 closed to 1 open.
    double noise = 1;   ///< Factor on the noise of all sensors.
    double pressure_lag_s = 5e-3, flow_lag_s = 20e-3, temperature_lag_s = 1;
    Errors errors;
    std::vector<Fault> faults;
};

/// None when the file has no [airpath]. `seed` is for drawn errors. Throws InputError.
std::optional<Setup> read_setup(TomlFile &file, std::uint64_t seed);

} // namespace sixdeg::airpath
