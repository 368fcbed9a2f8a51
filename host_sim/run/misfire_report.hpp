// SPDX-License-Identifier: MIT
// The misfire monitor's figures for people and for summary.json.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "run/misfire_score.hpp"

namespace sixdeg {

nlohmann::ordered_json misfire_json(const MisfireFigures &figures);
void print_misfire(const MisfireFigures &figures);

} // namespace sixdeg
