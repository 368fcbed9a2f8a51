// SPDX-License-Identifier: MIT
// The misfire monitor's figures for people and for summary.json.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "cli/firing_report.hpp"
#include "score/misfire_score.hpp"
#include "plant/scenario/scenario.hpp"

namespace sixdeg {

/// The separation of the Neyman-Pearson detector: work of a firing over the mean of the two deviations, sd_1 the bound of
/// one firing's torque, sd_0 that and the scenario's cyclic variation at its first load. 0 where there is no bound.
double separation_bound(const Scenario &scenario, const std::optional<FiringBounds> &bounds);

/// Whose verdicts count, by the tune: "monitor", or an observer of document 000 with its number type.
std::string method_of(const sd_parameters_t &tune);
/// Detection and false alarms of a method whose index nobody hears.
nlohmann::ordered_json beside_json(const MisfireFigures &figures);
void print_beside(const char *heading, const MisfireFigures &figures);
nlohmann::ordered_json misfire_json(const MisfireFigures &figures, double separation_bound);
void print_misfire(const char *heading, const MisfireFigures &figures, double separation_bound);

} // namespace sixdeg
