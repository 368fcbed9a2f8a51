// SPDX-License-Identifier: MIT
// The figures of single firings and of imbalance beside the bound of what any estimator could know (studies/limits/firing_bound.hpp)
// on the same wheel, at the run's speed, with the encoder's true noise.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "loop/bench_run.hpp"

namespace sixdeg {

/// Standard deviations, % of the mean combustion torque. Load constant over the window, and walking as the filter is told; firings free to
/// change as the firmware's prior says; 25 cycles seen; tooth errors of the encoder, or what learning left of them, stay for all.
struct FiringBounds {
    double single_percent, imbalance_percent;
    double single_walk_percent, imbalance_walk_percent;
};

/// Nothing without figures, or where the engine file tells no pulses.
std::optional<FiringBounds> firing_bounds(const Scenario &scenario, const sd_parameters_t &tune, const RunResult &result);

nlohmann::ordered_json firing_json(const RunResult &result, const std::optional<FiringBounds> &bounds);
void print_firing(const char *heading, const RunResult &result, const std::optional<FiringBounds> &bounds);

} // namespace sixdeg
