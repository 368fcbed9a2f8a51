// SPDX-License-Identifier: MIT
// The firmware as a process of its own at one end of a bus.
#pragma once
#include <string>

#include "bus/bus.hpp"
extern "C" {
#include "sd_ecu.h"
}

namespace sixdeg {

/// Events in, firmware, events out, until a signal wants the program to stop. Throws InputError when another ecu
/// is on the bus.
void run_ecu(Bus &bus, const std::string &transport, const sd_calibration_t &calibration);

} // namespace sixdeg
