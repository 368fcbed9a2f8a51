// SPDX-License-Identifier: MIT
#include "studies/loop/loop_case.hpp"

#include <cmath>

#include "design/calibration.hpp"
#include "design/perturbation.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

constexpr const char *kBase = "engine = \"diesel_22.toml\"\n[run]\nduration_s = 12\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 9\n"
                              "[cylinders]\nfuel_percent = [6, 9, -3, -8]\n[cyclic]\ncov_percent = 1\n"
                              "[uego]\nnoise_per_rthz = 1.83e-4\n[control]\nbalance_on_s = [2, 1000]\n";

} // namespace

Scenario loop_scenario(const std::vector<std::string> &changes, const std::string &file) {
    if (!file.empty()) return read_scenario(std::filesystem::path(SD_DATA "/scenarios") / file, changes);
    TomlFile base("loop", kBase);
    for (const std::string &change : changes) base.set(change);
    return read_scenario(base, SD_DATA "/engines");
}

RunResult run_loop(const LoopCase &loop, RunTables *tables) {
    Scenario scenario = loop_scenario(loop.scenario, loop.file);
    scenario.seed = loop.seed;
    if (loop.change) loop.change(scenario.engine);
    EngineFile belief = scenario.engine.shared;
    if (loop.perturbed) belief = perturbed(belief, draw_perturbation(belief, loop.seed));
    // No delay can be believed to be below 0: then it is the true one that is longer.
    const double late_s = loop.delay_error_deg * kRadPerDeg / scenario.speed_radps.at(0);
    (late_s > 0 ? belief : scenario.engine.shared).exhaust->dead_time_s += std::abs(late_s);
    TomlFile tune("tune", "");
    for (const std::string &parameter : loop.tune) tune.set(parameter);
    return run_on_bench(scenario, calibrate(belief, read_tune(tune), "tune"), tables, loop.kept);
}

} // namespace sixdeg
