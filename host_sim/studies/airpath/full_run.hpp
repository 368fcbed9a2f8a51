// SPDX-License-Identifier: MIT
// The full air path without a crank, and the firmware's bank of observers on what its sensors say: a second takes a millisecond.
#pragma once
#include <functional>
#include <vector>

#include "plant/airpath/air_path.hpp"
#include "plant/engine/plant_engine.hpp"

extern "C" {
#include "sd_airpath_bank.h"
}

namespace sixdeg {

/// What the engine does, what valve and vanes are told, and what goes wrong.
struct FullCase {
    Profile speed_radps, bmep_pa;
    airpath::Setup setup;
    double seconds = 30;
    std::uint64_t seed = 1;
};

/// kg/s of fuel that a demand takes without a simulated crank: brake work and friction over the efficiency of [plant.airpath].
double fuel_kgps(const PlantEngine &engine, double speed_radps, double bmep_pa);

/// Runs the air path alone and hands on every reading, 10 ms apart.
void run_full(const PlantEngine &engine, const FullCase &c, const std::function<void(const airpath::Readings &,
    const airpath::Truth &)> &take);

/// What the bank takes of one time's readings; all of them speak.
sd_airpath_in_f32_t bank_input(const airpath::Readings &readings, const airpath::Truth &truth);

/// The bank begins to say something other than no fault.
struct Alarm {
    double time_s;
    int fault; ///< sd_airpath_fault_t.
};

struct FullResult {
    double decides_s = -1; ///< From when on; below 0 never.
    std::vector<Alarm> alarms;
    bool suspect = false;  ///< What it learned is as large as half a fault of interest.

    /// The first alarm in [from_s, to_s); nullptr if there is none.
    const Alarm *first(double from_s, double to_s) const;
};

/// The same with the bank listening.
FullResult judge_full(const PlantEngine &engine, const sd_airpath_tables_f32_t &tables, const sd_airpath_config_f32_t &config,
                      const FullCase &c);

} // namespace sixdeg
