// SPDX-License-Identifier: MIT
#include "studies/airpath/full_cases.hpp"

#include <cmath>

#include "common/random.hpp"

namespace sixdeg {
namespace {

constexpr std::uint32_t kWander = 900; // streams of these cases
constexpr double kKnotS = 0.25;

/// Mean and a sine of a random phase and a period of 6 to 20 s.
Profile wander(double mean, double swing, double seconds, RandomStream &random) {
    const double phase = 2 * kPi * random.uniform(), period_s = 6 + 14 * random.uniform();
    std::vector<double> time, value;
    for (double t = 0; t <= seconds + kKnotS; t += kKnotS) {
        time.push_back(t);
        value.push_back(mean + swing * std::sin(phase + 2 * kPi * t / period_s));
    }
    return Profile(std::move(time), std::move(value));
}

airpath::Fault fault(int place, airpath::FaultKind kind, double size = 0) {
    airpath::Fault f;
    f.place = place, f.kind = kind, f.from_s = 0, f.size = size;
    f.period_s = 1, f.ramp_s = 5;
    return f;
}

} // namespace

FullCase wandering(double seconds, std::uint64_t seed, double bmep_pa) {
    RandomStream random(seed, kWander);
    FullCase c;
    c.seconds = seconds, c.seed = seed;
    c.speed_radps = wander(1500, 60, seconds, random).scaled(kRadpsPerRpm);
    c.bmep_pa = wander(bmep_pa, 0.06 * bmep_pa, seconds, random);
    c.setup.egr = wander(0.35, 0.05, seconds, random);
    c.setup.vgt = wander(0.44, 0.04, seconds, random);
    c.setup.errors = airpath::draw_errors(kParameterError, RandomStream(seed, kWander + 1));
    return c;
}

void add_load_step(FullCase &c, double from_s, double to_s, double bmep_pa) {
    constexpr double kStepS = 0.05;
    std::vector<double> time, value;
    for (double t = 0; t < from_s; t += kKnotS) time.push_back(t), value.push_back(c.bmep_pa.at(t));
    const double before = c.bmep_pa.at(from_s), after = c.bmep_pa.at(to_s);
    for (const auto &[t, v] : {std::pair{from_s, before}, {from_s + kStepS, bmep_pa}, {to_s, bmep_pa}, {to_s + kStepS, after}})
        time.push_back(t), value.push_back(v);
    c.bmep_pa = Profile(std::move(time), std::move(value));
}

std::vector<FaultCase> step_cases() {
    using namespace airpath;
    const auto step = FaultKind::step;
    return {{"EGR +0.1", {fault(kEgrActuator, step, 0.1)}, SD_AIRPATH_EGR_FAULT},
            {"VGT -0.1", {fault(kVgtActuator, step, -0.1)}, SD_AIRPATH_VGT_FAULT},
            {"EGR +0.05", {fault(kEgrActuator, step, 0.05)}, SD_AIRPATH_EGR_FAULT},
            {"VGT -0.05", {fault(kVgtActuator, step, -0.05)}, SD_AIRPATH_VGT_FAULT}};
}

std::vector<FaultCase> other_cases() {
    using namespace airpath;
    const auto sensor = [](const char *name, int channel, double size) {
        return FaultCase{name, {fault(kFirstSensor + channel, FaultKind::step, size)}, SD_AIRPATH_NO_FAULT};
    };
    return {{"EGR valve stuck, told to move", {fault(kEgrActuator, FaultKind::stuck)}, SD_AIRPATH_EGR_FAULT, true},
            {"vanes stuck, told to move", {fault(kVgtActuator, FaultKind::stuck)}, SD_AIRPATH_VGT_FAULT, true},
            {"EGR valve at a tenth of its speed", {fault(kEgrActuator, FaultKind::slow, 0.1)}, SD_AIRPATH_EGR_FAULT, true},
            {"vanes at a tenth of their speed", {fault(kVgtActuator, FaultKind::slow, 0.1)}, SD_AIRPATH_VGT_FAULT, true},
            {"EGR +0.1, half of every second", {fault(kEgrActuator, FaultKind::intermittent, 0.1)}, SD_AIRPATH_EGR_FAULT},
            {"VGT -0.1, half of every second", {fault(kVgtActuator, FaultKind::intermittent, -0.1)}, SD_AIRPATH_VGT_FAULT},
            {"EGR +0.1, growing for 5 s", {fault(kEgrActuator, FaultKind::ramp, 0.1)}, SD_AIRPATH_EGR_FAULT},
            {"VGT -0.1, growing for 5 s", {fault(kVgtActuator, FaultKind::ramp, -0.1)}, SD_AIRPATH_VGT_FAULT},
            sensor("air flow +3 g/s", kAirFlow, 3e-3),
            sensor("intake pressure +2 kPa", kIntakePressure, 2e3),
            sensor("exhaust pressure +4 kPa", kExhaustPressure, 4e3),
            sensor("charge temperature +5 K", kChargeTemperature, 5),
            sensor("EGR temperature +20 K", kEgrTemperature, 20),
            sensor("exhaust temperature +20 K", kExhaustTemperature, 20),
            {"leak of 10 mm2 in the intake", {fault(kIntakeLeak, FaultKind::step, 10e-6)}, SD_AIRPATH_NO_FAULT},
            {"leak of 40 mm2 in the intake", {fault(kIntakeLeak, FaultKind::step, 40e-6)}, SD_AIRPATH_NO_FAULT},
            {"EGR +0.1 and VGT -0.1 at once",
             {fault(kEgrActuator, FaultKind::step, 0.1), fault(kVgtActuator, FaultKind::step, -0.1)},
             SD_AIRPATH_UNCLEAR}};
}

} // namespace sixdeg
