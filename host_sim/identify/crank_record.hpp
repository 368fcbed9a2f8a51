// SPDX-License-Identifier: MIT
// What `sixdeg identify` works on: when each tooth passed, and what was read beside it.
#pragma once
#include <vector>

#include "common/engine_file.hpp"

namespace sixdeg {

/// One tooth whose place in the cycle is known.
struct PlacedTooth {
    double t_s;
    long place; ///< Wheel positions since position 0 of some cycle's first revolution; every 2 x positions a cycle begins.
};

/// One reading of a sensor; it holds until the next one, but pressure, which is read between them.
struct TimedValue {
    double t_s, value;
};

/// A recording after decoding. Everything ascends in time; lists that nobody recorded are empty.
struct CrankRecord {
    std::vector<PlacedTooth> teeth;
    std::vector<TimedValue> pressure; ///< Of the cylinder that fires first in the engine file, bar; its level may be anything.
    std::vector<TimedValue> intake;   ///< Intake pressure, bar absolute.
    std::vector<TimedValue> fuel;     ///< Injected, mg a stroke; 0 in fuel cut.
};

/// Mean of the readings in [from, to], the one that holds at its beginning included; NaN where nothing was read before its end.
double mean_within(const std::vector<TimedValue> &readings, double from_s, double to_s);

/// Stretch of time without combustion, in s.
struct TimeWindow {
    double from_s, to_s;
};

/// One cycle of the engine, from 360 deg ahead of the first cylinder's firing TDC to 360 deg behind it, as the engine file has the wheel.
struct WholeCycle {
    std::vector<double> t_s;   ///< Of its teeth.
    std::vector<double> deg;   ///< Where the file has them, from that TDC.
    std::vector<int> position; ///< Of the wheel.
    double speed_radps;        ///< Mean.
    bool motored;              ///< Neither it nor the cycle before burned anything.
    double intake_bar;         ///< Mean reading; NaN without.
};

/// The cycles of which no tooth is missing but those that the wheel has not. `motored`: stretches that the caller knows to be without
/// combustion, beside those in which `record.fuel` is 0.
std::vector<WholeCycle> whole_cycles(const EngineFile &engine, const CrankRecord &record, const std::vector<TimeWindow> &motored);

} // namespace sixdeg
