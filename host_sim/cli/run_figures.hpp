// SPDX-License-Identifier: MIT
// The figures of a run for summary.json and for the screen, nominal and perturbed calibration side by side.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "design/perturbation.hpp"
#include "loop/bench_run.hpp"

namespace sixdeg {

/// A calibration that is wrong on purpose, and what the same run gave with it.
struct PerturbedRun {
    Perturbation perturbation;
    RunResult result;
};

/// Adds "torque" and "cylinders" of the nominal run, and "perturbed".
void add_figures(nlohmann::ordered_json &summary, const RunResult &nominal,
                 const std::optional<PerturbedRun> &perturbed);
void print_accuracy(const RunResult &nominal, const std::optional<PerturbedRun> &perturbed);

} // namespace sixdeg
