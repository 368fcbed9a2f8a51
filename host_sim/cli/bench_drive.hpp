// SPDX-License-Identifier: MIT
// What the firmware's blocks are timed on: an engine at 1500 rpm and 9 bar as an ecu meets it, and ecus that have followed it.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "design/calibration.hpp"
extern "C" {
#include "sd_ecu.h"
}

namespace sixdeg {

/// Changes parameters of a page before an ecu starts with it.
using BenchTune = std::function<void(sd_parameters_t &)>;

/// The calibration page of the bench's engine, with other parameters.
std::unique_ptr<sd_calibration_t> bench_page(const BenchTune &tune = {});

/// All that goes into an ecu in some seconds, in order of time, with a lambda sensor. The engine misses no firing.
const std::vector<sd_event_t> &bench_events();

/// An ecu after all of bench_events(), and its page.
struct WarmEcu {
    std::unique_ptr<sd_calibration_t> page;
    std::unique_ptr<sd_ecu_t> ecu;
};

/// Made once for each set of parameters. Throws std::logic_error when the page is refused.
const WarmEcu &warm_ecu(const BenchTune &tune = {});

/// The placed teeth of the last whole cycle of bench_events(), as the decoder sees them.
const std::vector<sd_tooth_t> &bench_teeth();

} // namespace sixdeg
