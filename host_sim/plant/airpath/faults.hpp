// SPDX-License-Identifier: MIT
// What goes wrong in the air path of one run: SCENARIO.toml, [[airpath.fault]].
#pragma once
#include <array>
#include <vector>

#include "common/toml_file.hpp"

namespace sixdeg::airpath {

/// What the ecu reads of the air path, in SI units; positions from 0 to 1.
enum Channel { kAirFlow, kIntakePressure, kExhaustPressure, kChargeTemperature, kEgrTemperature, kExhaustTemperature, kEgrPosition,
    kVgtPosition,
               kEgrCommand, kVgtCommand, kChannels };

/// As the signal table names them.
constexpr std::array<const char *, kChannels> kChannelNames{
    "air.flow", "air.intake_pressure", "exhaust.pressure", "air.charge_temperature", "egr.temperature", "exhaust.temperature",
        "egr.position",
    "vgt.position", "egr.command", "vgt.command"};

/// Where a fault sits. A sensor's is its channel plus kFirstSensor.
enum Place { kEgrActuator, kVgtActuator, kIntakeLeak, kFirstSensor };

enum class FaultKind {
    step,         ///< An offset from from_s to to_s.
    ramp,         ///< An offset that grows for ramp_s and stays until to_s.
    intermittent, ///< An offset in the first half of every period_s.
    stuck,        ///< Stays where it is; a sensor's reading stays.
    slow,         ///< An actuator whose loop has the share `size` of its speed.
    silent,       ///< A sensor that is not read.
    out_of_range, ///< A sensor that reads far above its range.
};

struct Fault {
    int place = 0; ///< Place.
    FaultKind kind = FaultKind::step;
    double from_s = 0, to_s = 1e300;
    double size = 0; ///< Actuators: of the full stroke. Leak: m2. Sensors: in the channel's unit.
    double ramp_s = 1, period_s = 1;

    bool active(double t_s) const { return t_s >= from_s && t_s < to_s; }
    /// Of the kinds that are an offset; 0 of others and at other times.
    double offset(double t_s) const;
};

/// Sum of the offsets at a place.
double offset_at(const std::vector<Fault> &faults, int place, double t_s);
/// The first active fault of a kind at a place; nullptr if there is none.
const Fault *find_fault(const std::vector<Fault> &faults, int place, FaultKind kind, double t_s);

/// All of [[airpath.fault]]. Throws InputError.
std::vector<Fault> read_faults(TomlFile &file);

} // namespace sixdeg::airpath
