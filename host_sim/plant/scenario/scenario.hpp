// SPDX-License-Identifier: MIT
// SCENARIO.toml: what happens to the engine in one run. Field by field: docs/reference/scenario.md.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plant/airpath/setup.hpp"
#include "plant/engine/plant_engine.hpp"
#include "plant/exhaust/pressure_sensor.hpp"
#include "plant/exhaust/uego.hpp"
#include "plant/sensors/pickup.hpp"
#include "plant/vehicle/car_behind.hpp"

namespace sixdeg {

/// Who decides the speed.
enum class SpeedMode {
    dyno,       ///< Fuel follows load.bmep_bar; the brake's torque holds the speed, corrected once a cycle.
    governor,   ///< The load is given; fuel holds the speed.
    free,       ///< Fuel and load are given; the speed goes where they send it.
    prescribed, ///< The crank turns exactly as told; torques act on nothing.
};

/// From at_s on, a cylinder's injector gives this share of the nominal fuel.
struct FuelStep {
    double at_s;
    int cylinder; ///< Physical, 1-based.
    double factor;
};

/// A combustion that does not happen as it should.
struct MisfireEvent {
    std::int64_t cycle;
    int cylinder; ///< Physical, 1-based.
    double burned_fraction;
};

struct Scenario {
    std::string name;
    std::string file; ///< Where it was read from, for messages.
    std::filesystem::path engine_path; ///< Relative paths count from the scenario's folder.
    PlantEngine engine;
    std::uint64_t seed = 1;

    double duration_s = 0; ///< Exactly one of duration_s and cycles is above 0.
    std::int64_t cycles = 0;
    double step_deg = 0.5;
    double start_deg = 0; ///< Crank angle at time 0, [0, 720).

    SpeedMode speed_mode = SpeedMode::dyno;
    Profile speed_radps; ///< Over time; for SpeedMode::free the start value only.

    Profile bmep_pa; ///< Demand; sets fuel in dyno, free and prescribed, the load torque in governor.
    Profile load_nm; ///< Only with load_given: brake torque in free and governor.
    bool load_given = false;
    std::vector<double> fuel_cut_s; ///< Pairs from, to: no fuel is injected at intake closings in [from, to).
    double road_rms_nm = 0, road_low_hz = 3, road_high_hz = 15;

    std::vector<double> fuel_factor, trapped_factor,
        compression_factor; ///< By physical cylinder, 1 = nominal.

    std::vector<FuelStep> fuel_steps; ///< Ascending in time; on top of nothing: each replaces fuel_factor.

    Profile cyclic_cov; ///< Standard deviation of the heat over its mean, over bmep in Pa; 0 none.
    double cyclic_start_sd_rad = 0; ///< Of the start of combustion.
    double cyclic_duration_cov = 0; ///< Of the duration of combustion.

    std::vector<MisfireEvent> misfires; ///< Ascending by cycle.
    std::vector<int> continuous;        ///< Physical cylinders that never burn properly.
    double misfire_rate = 0;            ///< Probability for each combustion.
    double misfire_burned_fraction = 0; ///< Of random and continuous ones.

    std::optional<VehicleSetup> vehicle; ///< The car of engine.shared.driveline; none: what turns with the crank is rigid.

    EncoderFaults encoder;
    std::vector<double> balance_on_s; ///< Pairs from, to: the firmware may trim the fuel.
    std::optional<ExhaustSensorSetup> exhaust_sensors; ///< Beside the lambda sensor; needs one.
    std::optional<airpath::Setup> air_path; ///< With it the air path runs; needs engine.air_path.
    std::optional<UegoSetup> uego; ///< With it the exhaust side runs; needs engine.shared.exhaust.
};

/// Reads scenario and engine file. Every error names file, field and range. Throws InputError.
Scenario read_scenario(const std::filesystem::path &path, const std::vector<std::string> &overrides = {});
/// The same from a file opened before; `folder` is where relative paths count from.
Scenario read_scenario(TomlFile &file, const std::filesystem::path &folder);

} // namespace sixdeg
