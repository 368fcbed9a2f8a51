// SPDX-License-Identifier: MIT
#include "studies/misfire/misfire_set.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "common/error.hpp"
#include "common/random.hpp"
#include "common/streams.hpp"

namespace sixdeg {
namespace {

constexpr double kOwnPatternDeg = 0.02, kMostPatternDeg = 0.2;
constexpr double kLeastGamma = 1.30, kMostGamma = 1.38, kMostWallFactor = 2;
constexpr double kRoadNm = 60;

const char *file_of(EngineKind kind) {
    switch (kind) {
    case EngineKind::rigid: return "diesel_22.toml";
    case EngineKind::twisting: return "eight_diesel.toml";
    case EngineKind::dual_mass: return "triple_10.toml";
    }
    return "";
}

/// What differs from the nominal engine goes to the plant alone.
void make_other(PlantEngine &plant, const SetEngine &engine) {
    if (engine.gamma > 0) plant.gas_cv_over_r = {1 / (engine.gamma - 1), 0, 0};
    plant.wall_factor = engine.wall_factor;
}

std::vector<SetFiring> firings_of(const PlantRecord &record, const EngineFile &engine) {
    std::vector<SetFiring> firings;
    for (const CycleTruth &c : record.cycles) {
        const auto lane = std::find(engine.firing_order.begin(), engine.firing_order.end(), c.cylinder) - engine.firing_order.begin();
        firings.push_back({c.cycle, c.cylinder, 720 * double(c.cycle) + engine.firing_tdc_deg[std::size_t(lane)], c.tdc_time_s,
                           c.fuel_kg * 1e6, c.misfire});
    }
    std::sort(firings.begin(), firings.end(), [](const SetFiring &a, const SetFiring &b) { return a.tdc_deg < b.tdc_deg; });
    return firings;
}

} // namespace

const char *name_of(EngineKind kind) {
    constexpr const char *kNames[] = {"rigid", "twisting", "dual-mass"};
    return kNames[int(kind)];
}

const char *name_of(Physics physics) { return physics == Physics::own ? "own" : "other"; }

std::vector<SetEngine> draw_engines(EngineKind kind, Physics physics, int count, std::uint64_t first_seed) {
    std::vector<SetEngine> engines;
    for (int i = 0; i < count; ++i) {
        SetEngine engine{kind, physics, first_seed + std::uint64_t(i), 0, 1, kOwnPatternDeg};
        RandomStream random(engine.seed, stream::kMisfireSet);
        if (physics == Physics::other) {
            engine.gamma = kLeastGamma + (kMostGamma - kLeastGamma) * random.uniform();
            engine.wall_factor = kMostWallFactor * random.uniform();
            engine.pattern_rms_deg = kOwnPatternDeg + (kMostPatternDeg - kOwnPatternDeg) * random.uniform();
        }
        engines.push_back(engine);
    }
    return engines;
}

std::vector<SetPoint> set_points(EngineKind kind, Physics physics) {
    // With other physics, the air that three cylinders breathe does not always burn the fuel that 9 bar take.
    const double high_bar = kind == EngineKind::dual_mass && physics == Physics::other ? 5 : 9;
    std::vector<SetPoint> points;
    const auto add = [&](double road_nm, double jitter_deg) {
        for (const int rpm : {1000, 1500, 3000, kind == EngineKind::twisting ? 4500 : 6000}) {
            for (const double bar : {1.0, 3.0, high_bar}) {
                // The diesel has so little inertia there that two misfires in a row stop it.
                if (kind == EngineKind::rigid && rpm == 1000 && bar > 3) continue;
                points.push_back({rpm, bar, road_nm, jitter_deg});
            }
        }
    };
    add(0, 0.01);
    add(0, 0.02);
    add(kRoadNm, 0.01);
    return points;
}

EngineFile nominal_engine(EngineKind kind) {
    return read_plant_engine(std::filesystem::path(SD_DATA "/engines") / file_of(kind)).shared;
}

Scenario made_scenario(const SetEngine &engine, const std::string &text) {
    TomlFile file("set", fmt::format("engine = \"{}\"\nseed = {}\n{}", file_of(engine.kind), engine.seed, text));
    Scenario scenario = read_scenario(file, SD_DATA "/engines");
    make_other(scenario.engine, engine);
    scenario.encoder.pattern_rms_deg = engine.pattern_rms_deg;
    return scenario;
}

Scenario set_scenario(const SetEngine &engine, const SetPoint &point, int cycles) {
    return made_scenario(engine, fmt::format("[run]\ncycles = {}\n[speed]\nrpm = {}\n[load]\nbmep_bar = {}\nroad_rms_nm = {}\n"
                                           "[cyclic]\ncov_percent = [20, 12.5, 5]\nbmep_bar = [1, 3, 5]\n[misfires]\none_in = 50\n"
                                           "[encoder]\njitter_deg = {}\n",
                                           cycles, point.rpm, point.bmep_bar, point.road_rms_nm, point.jitter_deg));
}

sd_kept_t learn_engine(const SetEngine &engine, const sd_calibration_t &page) {
    const Scenario lesson = made_scenario(engine, "[run]\nduration_s = 8\n[speed]\nrpm = [3000, 3000, 1500, 1500]\ntime_s = [0, 3, 4, 8]\n"
                                                "[load]\nbmep_bar = 0\nfuel_cut_s = [0.1, 8]\n[encoder]\njitter_deg = 0.01\n");
    return run_on_bench(lesson, page, nullptr).learned;
}

SetRun run_set(const SetEngine &engine, const SetPoint &point, int cycles, const sd_calibration_t &page, const sd_kept_t &learned) {
    const Scenario scenario = set_scenario(engine, point, cycles);
    SetRun run;
    FiringListener listener;
    const auto bench = std::make_unique<EcuBench>(page);
    if (!bench->resume(learned)) throw InputError("tooth pattern", "", "is of another wheel");
    bench->listen([&](bool out, const sd_event_t &event) {
        run.record.hear(out, event);
        listener.hear(out, event);
    });
    run.stalled = run_scenario(scenario, page, *bench, nullptr, &run.record).stalled;
    run.firings = firings_of(run.record, scenario.engine.shared);
    run.verdicts = listener.verdicts();
    run.intake_pa = scenario.engine.intake_pressure_pa.at(scenario.bmep_pa.at(0));
    return run;
}

} // namespace sixdeg
