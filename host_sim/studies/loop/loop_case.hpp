// SPDX-License-Identifier: MIT
// The fuel balance in a closed loop, with a calibration that is wrong by known amounts: what `sixdeg study loop` and the tests run.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "loop/bench_run.hpp"

namespace sixdeg {

struct LoopCase {
    std::vector<std::string> scenario = {}; ///< Changes field=value of the base below.
    std::vector<std::string> tune = {};     ///< Parameters, key=value.
    double delay_error_deg = 0;        ///< Believed less true delay to the sensor, at the case's first speed.
    bool perturbed = false;            ///< All else of the calibration wrong too, drawn from the seed.
    std::uint64_t seed = 1;
    std::string file = {};             ///< Of host_sim/data/scenarios, in place of the base below.
    const sd_kept_t *kept = nullptr;   ///< What an earlier start learned; nullptr: nothing.
    std::function<void(PlantEngine &)> change = {}; ///< Of the plant, before the calibration sees what a drawing tells of it.
};

/// The base with changes: diesel_22.toml, 1500 rpm, 9 bar, injectors +6, +9, -3, -8 %, 1 % cyclic variation, sensor noise 0.5 % a
/// position, 12 s, trims allowed from 2 s on.
Scenario loop_scenario(const std::vector<std::string> &changes, const std::string &file = {});
/// Runs it; `tables` may be nullptr.
RunResult run_loop(const LoopCase &loop, RunTables *tables = nullptr);

} // namespace sixdeg
