// SPDX-License-Identifier: MIT
// A made set for detectors of misfires: edge times of simulated engines with the truth of every firing, all of it from seeds.
//
//     for (const SetEngine &engine : draw_engines(EngineKind::rigid, Physics::other, 10, 1))
//         for (const SetPoint &point : set_points())
//             const SetRun run = run_set(engine, point, 600, page, &learned);
#pragma once
#include <string>
#include <vector>

#include "studies/observers/recorded_run.hpp"

namespace sixdeg {

/// What the crank is.
enum class EngineKind {
    rigid,     ///< The diesel with four cylinders.
    twisting,  ///< Eight cylinders on a crank that twists, the wheel at its front end.
    dual_mass, ///< Three cylinders and a dual-mass flywheel.
};
/// What gas, walls and wheel of the simulated engine are.
enum class Physics {
    own,   ///< Air over temperature, the engine file's wall loss, a wheel of 0.02 deg.
    other, ///< Constant gamma, wall loss and wheel drawn, of which no calibration knows.
};
const char *name_of(EngineKind kind);
const char *name_of(Physics physics);

/// One engine of the set.
struct SetEngine {
    EngineKind kind;
    Physics physics;
    std::uint64_t seed;     ///< Of all that is random in its runs, the wheel included.
    double gamma;           ///< Ratio of specific heats, [1.30, 1.38]; 0: air.
    double wall_factor;     ///< On the wall loss after Eichelberg, [0, 2].
    double pattern_rms_deg; ///< Of the wheel's teeth, [0.02, 0.2] deg.
};

/// One condition of running.
struct SetPoint {
    int rpm;
    double bmep_bar;
    double road_rms_nm; ///< Of the rough road's torque; 0: smooth.
    double jitter_deg;  ///< Of each edge.
};

/// One combustion, and what detectors may be told of it.
struct SetFiring {
    std::int64_t cycle;
    int cylinder;      ///< Physical, 1-based.
    double tdc_deg;    ///< Crank angle of its TDC, never wrapping.
    double tdc_time_s;
    double fuel_mg;    ///< Injected.
    bool misfire;      ///< The truth.
};

struct SetRun {
    PlantRecord record;
    std::vector<SetFiring> firings;      ///< Ascending by angle; of complete cycles.
    std::vector<FiringVerdict> verdicts; ///< The monitor's, in the ecu.
    double intake_pa; ///< What a sensor in the intake manifold shows.
    bool stalled;
};

/// `count` engines; engine i has the seed first_seed + i.
std::vector<SetEngine> draw_engines(EngineKind kind, Physics physics, int count, std::uint64_t first_seed);
/// Smooth roads with jitter of 0.01 and 0.02 deg and a rough one with 0.01 deg, over 1000 to 6000 rpm (twisting: 4500) and 1 to 9 bar
/// (dual-mass with other physics: 5).
std::vector<SetPoint> set_points(EngineKind kind, Physics physics);

/// The engine file the calibration is made of: the nominal engine.
EngineFile nominal_engine(EngineKind kind);
/// A scenario of that engine; `text` is the rest of the scenario's file.
Scenario made_scenario(const SetEngine &engine, const std::string &text);
/// The scenario of one run, misfires 1 in 50, cyclic variation 20 % at 1 bar, 12.5 % at 3 bar and 5 % from 5 bar on.
Scenario set_scenario(const SetEngine &engine, const SetPoint &point, int cycles);
/// What the ecu learns in a fuel cut at 3000 and 1500 rpm, before all runs of that engine.
sd_kept_t learn_engine(const SetEngine &engine, const sd_calibration_t &page);
/// Plant and ecu together.
SetRun run_set(const SetEngine &engine, const SetPoint &point, int cycles, const sd_calibration_t &page, const sd_kept_t &learned);

} // namespace sixdeg
