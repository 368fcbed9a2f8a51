// SPDX-License-Identifier: MIT
#include "plant/airpath/faults.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sixdeg::airpath {
namespace {

constexpr std::array<const char *, 7> kKindNames{"step", "ramp", "intermittent", "stuck", "slow", "silent", "out_of_range"};

int read_place(TomlFile &file, const std::string &field) {
    const std::string name = file.text(field);
    if (name == "egr") return kEgrActuator;
    if (name == "vgt") return kVgtActuator;
    if (name == "leak") return kIntakeLeak;
    for (int channel = 0; channel < kEgrCommand; ++channel)
        if (name == kChannelNames[std::size_t(channel)]) return kFirstSensor + channel;
    file.fail(field, "'" + name + "' is not \"egr\", \"vgt\", \"leak\" or a sensor of the air path, as \"air.flow\"");
}

FaultKind read_kind(TomlFile &file, const std::string &field, int place) {
    const std::string name = file.text_or(field, "step");
    const auto found = std::find(kKindNames.begin(), kKindNames.end(), name);
    if (found == kKindNames.end())
        file.fail(field, fmt::format("'{}' is not one of {}", name, fmt::join(kKindNames, ", ")));
    const auto kind = FaultKind(found - kKindNames.begin());
    const bool of_actuator = place <= kVgtActuator, of_sensor = place >= kFirstSensor;
    if (kind == FaultKind::slow && !of_actuator) file.fail(field, "only \"egr\" and \"vgt\" can be slow");
    if ((kind == FaultKind::silent || kind == FaultKind::out_of_range) && !of_sensor) file.fail(field, "only a sensor can be " + name);
    if (kind == FaultKind::stuck && place == kIntakeLeak) file.fail(field, "a leak cannot be stuck");
    return kind;
}

/// The unit a user writes, over the SI unit.
double user_unit(int place) {
    switch (place - kFirstSensor) {
    case kAirFlow: return 1e-3;
    case kIntakePressure:
    case kExhaustPressure: return 1e5;
    default: return place == kIntakeLeak ? 1e-6 : 1;
    }
}

} // namespace

double Fault::offset(double t_s) const {
    if (!active(t_s)) return 0;
    const double since = t_s - from_s;
    switch (kind) {
    case FaultKind::step: return size;
    case FaultKind::ramp: return size * std::min(since / ramp_s, 1.0);
    case FaultKind::intermittent: return std::fmod(since, period_s) < period_s / 2 ? size : 0;
    default: return 0;
    }
}

double offset_at(const std::vector<Fault> &faults, int place, double t_s) {
    double sum = 0;
    for (const Fault &fault : faults)
        if (fault.place == place) sum += fault.offset(t_s);
    return sum;
}

const Fault *find_fault(const std::vector<Fault> &faults, int place, FaultKind kind, double t_s) {
    for (const Fault &fault : faults)
        if (fault.place == place && fault.kind == kind && fault.active(t_s)) return &fault;
    return nullptr;
}

std::vector<Fault> read_faults(TomlFile &file) {
    std::vector<Fault> faults;
    for (std::size_t i = 0; i < file.array_size("airpath.fault"); ++i) {
        const std::string at = fmt::format("airpath.fault[{}].", i);
        Fault f;
        f.place = read_place(file, at + "at");
        f.kind = read_kind(file, at + "kind", f.place);
        f.from_s = file.number(at + "from_s", {0, 1e6, "s"});
        f.to_s = file.number_or(at + "to_s", {0, 1e6, "s"}, 1e300);
        if (f.to_s <= f.from_s) file.fail(at + "to_s", "is not after from_s");
        const bool sized = f.kind != FaultKind::stuck && f.kind != FaultKind::silent && f.kind != FaultKind::out_of_range;
        if (sized) f.size = user_unit(f.place) * file.number(at + "size", {-1e4, 1e4, "of the stroke, mm2 or the sensor's unit"});
        if (f.kind == FaultKind::slow && (f.size <= 0 || f.size > 1)) file.fail(at + "size", "of a slow actuator is not in (0, 1]");
        if (f.kind == FaultKind::ramp) f.ramp_s = file.number(at + "ramp_s", {1e-3, 1e6, "s"});
        if (f.kind == FaultKind::intermittent) f.period_s = file.number(at + "period_s", {0.01, 1e6, "s"});
        faults.push_back(f);
    }
    return faults;
}

} // namespace sixdeg::airpath
