// SPDX-License-Identifier: MIT
// Sentences for a user whose engine file does not fit the engine.
#pragma once
#include <string>
#include <vector>

#include "common/engine_file.hpp"
#include "loop/evidence.hpp"

namespace sixdeg {

/// One for each contradiction between what was seen and the calibration, which is of this file and tune; in the order of Evidence.
std::vector<std::string> contradictions(const EngineFile &engine, const sd_parameters_t &tune, const Evidence &seen);
/// Prints them, each behind "warning: ".
void print_contradictions(const std::vector<std::string> &sentences);

} // namespace sixdeg
