// SPDX-License-Identifier: MIT
#include "plant/engine/plant_engine.hpp"

#include <cmath>

#include "common/files.hpp"
#include "plant/engine/gas.hpp"

namespace sixdeg {
namespace {

// Tables and fields that belong to read_engine.
constexpr const char *kSharedTables[] =
    {"cylinders", "valves", "combustion", "crank", "wheel", "cam", "timer", "exhaust", "uego", "driveline", "dual_mass", "torsion",
                                         "airpath"};

void read_air(TomlFile &file, PlantEngine &engine) {
    const auto pressure = file.numbers("plant.air.intake_pressure_bar", {0.1, 5, "bar"});
    if (pressure.empty()) file.fail("plant.air.intake_pressure_bar", "is empty");
    std::vector<double> bmep{0.0};
    if (file.has("plant.air.bmep_bar") || pressure.size() > 1) {
        bmep = file.numbers("plant.air.bmep_bar", {0, 40, "bar"}, pressure.size());
    }
    for (std::size_t i = 1; i < bmep.size(); ++i) {
        if (bmep[i] <= bmep[i - 1]) file.fail("plant.air.bmep_bar", "is not ascending");
    }
    engine.intake_pressure_pa = Profile(bmep, pressure).scaled(kPaPerBar);
    for (double &b : bmep) b *= kPaPerBar;
    engine.intake_pressure_pa = Profile(bmep, engine.intake_pressure_pa.value());
    engine.exhaust_pressure_pa =
        kPaPerBar * file.number_or("plant.air.exhaust_pressure_bar", {0.1, 6, "bar"}, 1.05);
    engine.crankcase_pressure_pa =
        kPaPerBar * file.number_or("plant.air.crankcase_pressure_bar", {0.5, 2, "bar"}, 1.013);
    engine.charge_temperature_k = file.number_or("plant.air.charge_temperature_k", {250, 500, "K"}, 330);
}

void read_valves(TomlFile &file, PlantEngine &engine) {
    engine.exhaust_open_rad = kRadPerDeg * engine.shared.exhaust_open_deg;
    engine.intake_close_rad = kRadPerDeg * engine.shared.intake_close_deg;
    engine.exchange_per_rad = file.number_or("plant.valves.exchange_per_rad", {1, 20, "1/rad"}, 6);
}

/// A gas of constant gamma has c_v/R = 1/(gamma - 1).
void read_gas(TomlFile &file, PlantEngine &engine) {
    engine.gas_cv_over_r = {gas::kB0, gas::kB1, gas::kB2};
    if (file.has("plant.gas.gamma")) engine.gas_cv_over_r = {1 / (file.number("plant.gas.gamma", {1.2, 1.5, ""}) - 1), 0, 0};
}

void read_losses(TomlFile &file, PlantEngine &engine) {
    engine.heating_value_jpkg =
        1e6 * file.number_or("plant.combustion.heating_value_mjpkg", {10, 130, "MJ/kg"}, 42.7);
    engine.stoichiometric_ratio = file.number_or("plant.combustion.stoichiometric_ratio", {5, 40, ""}, 14.6);
    engine.wall_temperature_k = file.number_or("plant.wall.temperature_k", {250, 700, "K"}, 430);
    engine.wall_factor = file.number_or("plant.wall.factor", {0, 5, ""}, 1);
    const auto fmep = file.numbers("plant.friction.fmep_bar", {0, 5, "bar"}, 3);
    for (std::size_t i = 0; i < 3; ++i) engine.fmep_pa[i] = kPaPerBar * fmep[i];
}

void read_exhaust(TomlFile &file, PlantEngine &engine) {
    PlantExhaust &e = engine.exhaust;
    const std::string at = "plant.exhaust.";
    if (file.has(at + "runner_l")) e.runner_m3 = file.numbers(at + "runner_l", {0, 5, "L"}, engine.shared.firing_order.size());
    for (double &volume : e.runner_m3) volume *= 1e-3;
    e.wall_wpk = file.number_or(at + "wall_wpk", {0, 100, "W/K"}, 0);
    e.wall_k = file.number_or(at + "wall_temperature_k", {250, 1200, "K"}, 500);
    e.back_pressure_pa = kPaPerBar * file.number_or(at + "back_pressure_bar", {0, 2, "bar"}, 0);
    e.rated_kgps = file.number_or(at + "back_pressure_kgps", {1e-3, 10, "kg/s"}, 0.1);
    e.turbine_inertia_kgm2 = file.number_or(at + "turbine_inertia_kgm2", {1e-7, 1, "kg m2"}, 3e-5);
    e.turbine_efficiency = file.number_or(at + "turbine_efficiency", {0.1, 0.9, ""}, 0.65);
    e.turbine_rated_radps = kRadpsPerRpm * file.number_or(at + "turbine_rated_rpm", {1e4, 4e5, "rpm"}, 1.5e5);
    e.turbine_rated_w = 1e3 * file.number_or(at + "turbine_rated_kw", {0.1, 1000, "kW"}, 10);
    e.turbine_swallow_drop = file.number_or(at + "turbine_swallow_drop", {0, 0.5, ""}, 0.1);
    e.egr_area_m2 = 1e-6 * file.number_or(at + "egr_area_mm2", {0, 5000, "mm2"}, 0);
    e.intake_m3 = 1e-3 * file.number_or(at + "intake_l", {0.2, 100, "L"}, 3);
}

} // namespace

double PlantEngine::fmep_at_pa(double speed_radps) const {
    const double n = speed_radps / kRadpsPerRpm / 1000;
    return fmep_pa[0] + n * (fmep_pa[1] + n * fmep_pa[2]);
}

PlantEngine read_plant_engine(const std::string &name, const std::string &text) {
    PlantEngine engine{};
    TomlFile shared(name, text);
    engine.shared = read_engine(shared);
    shared.finish();

    // A second reading of the same text, which knows only the fields below "plant".
    TomlFile file(name, text);
    file.text("name");
    if (file.has("guessed")) file.texts("guessed");
    for (const char *table : kSharedTables) file.ignore(table);
    if (!file.has("plant"))
        file.fail("plant", "is missing: this engine file has no data for the simulated engine");
    read_air(file, engine);
    read_valves(file, engine);
    for (const HeatPulse &p : engine.shared.pulses)
        engine.pulses.push_back({kRadPerDeg * p.start_deg, kRadPerDeg * p.duration_deg, p.shape, p.share});
    read_gas(file, engine);
    read_losses(file, engine);
    engine.driveline_inertia_kgm2 = file.number_or("plant.driveline.inertia_kgm2", {0, 100, "kg m2"}, 0);
    read_exhaust(file, engine);
    engine.air_path = airpath::read_full_data(file);
    engine.dual_mass = engine.shared.dual_mass;
    engine.torsion = engine.shared.torsion;
    if (engine.torsion) engine.torsion_modes = int(file.integer_or("plant.torsion.modes", 1, 3, 1));
    file.finish();
    return engine;
}

PlantEngine read_plant_engine(const std::filesystem::path &path) {
    return read_plant_engine(path.string(), read_file(path));
}

} // namespace sixdeg
