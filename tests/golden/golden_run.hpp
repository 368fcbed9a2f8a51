// SPDX-License-Identifier: MIT
// A golden run as its file tells it: an engine, a tune and what went into the ecu, all by name (docs/results/golden.md).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "design/calibration.hpp"
extern "C" {
#include "hal.h"
}

namespace sixdeg {

struct GoldenRun {
    std::string name;               ///< Of the file, without its ending.
    sd_calibration_t calibration;   ///< Made on this machine, in double, from the engine file and the tune.
    std::vector<sd_event_t> events; ///< What goes in, in order.
};

/// Reads FILE.run; the engine's file is looked for in `engines`. Throws InputError naming file and line: an event that
/// cannot be read, or an input or a parameter that the signal table does not have.
GoldenRun read_golden_run(const std::filesystem::path &file, const std::filesystem::path &engines);

} // namespace sixdeg
