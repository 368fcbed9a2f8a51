// SPDX-License-Identifier: MIT
// The firmware as a process of its own at one end of a bus.
#pragma once
#include <string>

#include "io/bus/bus.hpp"
#include "io/log/port_tap.hpp"
extern "C" {
#include "sd_ecu.h"
}

namespace sixdeg {

/// Events in, firmware, events out, until a signal wants the program to stop. `listener` (may be empty) hears of every
/// event. Throws InputError when another ecu is on the bus.
void run_ecu(Bus &bus, const std::string &transport, const sd_calibration_t &calibration, const EventListener &listener);

} // namespace sixdeg
