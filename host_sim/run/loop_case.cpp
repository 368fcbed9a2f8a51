// SPDX-License-Identifier: MIT
#include "run/loop_case.hpp"

#include "calibration/calibration.hpp"
#include "calibration/perturbation.hpp"
#include "engine/units.hpp"

namespace sixdeg {
namespace {

constexpr const char *kBase = "engine = \"diesel_22.toml\"\n[run]\nduration_s = 12\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 9\n"
                              "[cylinders]\nfuel_percent = [6, 9, -3, -8]\n[cyclic]\ncov_percent = 1\n"
                              "[uego]\nnoise_per_rthz = 1.83e-4\n[control]\nbalance_on_s = [2, 1000]\n";

} // namespace

RunResult run_loop(const LoopCase &loop, RunTables *tables) {
    TomlFile file("loop", kBase);
    for (const std::string &change : loop.scenario) file.set(change);
    Scenario scenario = read_scenario(file, SD_ENGINES);
    scenario.seed = loop.seed;
    EngineFile belief = scenario.engine.shared;
    if (loop.perturbed) belief = perturbed(belief, draw_perturbation(belief, loop.seed));
    belief.exhaust->dead_time_s += loop.delay_error_deg * kRadPerDeg / scenario.speed_radps.at(0);
    TomlFile tune("tune", "");
    for (const std::string &parameter : loop.tune) tune.set(parameter);
    return run_on_bench(scenario, calibrate(belief, read_tune(tune), "tune"), tables);
}

} // namespace sixdeg
