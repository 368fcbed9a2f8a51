// SPDX-License-Identifier: MIT
// Engines and scenarios for the plant's tests.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "plant/scenario/plant.hpp"

namespace plant_test {

using namespace sixdeg;

inline PlantEngine diesel() {
    return read_plant_engine(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
}

/// 1000 rpm and 5 bar on the 2.2 L diesel, 20 cycles, changed by "field=value" lines.
inline Scenario scenario(const std::vector<std::string> &changes = {}) {
    TomlFile file(
        "s.toml",
        "engine = \"diesel_22.toml\"\n[run]\ncycles = 20\n[speed]\nrpm = 1000\n[load]\nbmep_bar = 5\n");
    for (const auto &change : changes) file.set(change);
    return read_scenario(file, SD_ENGINES);
}

/// The line a user would read, "" when nothing was wrong.
inline std::string message(const std::function<void()> &action) {
    try {
        action();
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

struct Run {
    std::vector<EncoderEdge> edges;
    std::vector<CycleTruth> cycles;
    std::vector<StepTruth> steps;
};

inline Run run(const Scenario &scenario, std::uint64_t seed = 1) {
    Plant plant(scenario, seed);
    Run result;
    plant.record_steps(&result.steps);
    EncoderEdge edge;
    CycleTruth cycle;
    while (plant.next_edge(edge)) result.edges.push_back(edge);
    while (plant.next_cycle(cycle)) result.cycles.push_back(cycle);
    return result;
}

/// Steps `model` by `steps`, giving every charge `fuel_kg`.
inline void turn(EngineModel &model, int steps, double fuel_kg) {
    Charge charge;
    charge.fuel_kg = fuel_kg;
    for (int i = 0; i < steps; ++i) {
        ASSERT_TRUE(model.step());
        for (const Event *e = model.events_begin(); e != model.events_end(); ++e) {
            if (e->kind == EventKind::intake_close) model.set_charge(e->lane, charge);
        }
    }
}

inline std::vector<CylinderSpread> nominal(const PlantEngine &engine) {
    return std::vector<CylinderSpread>(std::size_t(engine.shared.cylinders()),
                                       {engine.shared.compression_ratio});
}

} // namespace plant_test
