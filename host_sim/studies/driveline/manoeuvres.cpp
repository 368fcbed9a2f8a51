// SPDX-License-Identifier: MIT
#include "studies/driveline/manoeuvres.hpp"

#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

double ramp(double t, double from_s, double to_s, double from, double to) {
    return from + std::clamp((t - from_s) / (to_s - from_s), 0.0, 1.0) * (to - from);
}

/// Torque off, clutch open from t0 to t0 + 0.3 s, closed over 0.3 s more, then the torque is back.
DriverInput shift(double t, double t0, double torque_nm, std::size_t before, std::size_t after) {
    DriverInput input;
    input.torque_nm = t < t0 ? ramp(t, t0 - 0.1, t0, torque_nm, 0) : ramp(t, t0 + 0.6, t0 + 0.8, 0, torque_nm);
    input.clutch_nm = t < t0 ? 1e9 : t < t0 + 0.3 ? 0 : t < t0 + 0.6 ? ramp(t, t0 + 0.3, t0 + 0.6, 10, 120) : 1e9;
    input.gear = t < t0 + 0.15 ? before : after;
    return input;
}

} // namespace

const std::vector<Manoeuvre> &manoeuvres() {
    static const std::vector<Manoeuvre> list{
        {"tip-in, coasting to 60 N m in 50 ms", 1500, -60, 4, 9, {0.125},
         [](double t) { return DriverInput{ramp(t, 5, 5.05, -8, 60)}; }},
        {"tip-out, 40 N m to coasting in 50 ms", 1800, 200, 2, 8, {0.125},
         [](double t) { return DriverInput{ramp(t, 3, 3.05, 40, -10)}; }},
        {"gear change, first to second to third", 1900, 200, 1, 12, {0.07, 0.125, 0.18},
         [](double t) { return t < 5 ? shift(t, 3, 30, 0, 1) : shift(t, 7, 40, 1, 2); }},
        {"clutch open for 1 s, then a lift", 2000, 100, 2, 9, {0.125},
         [](double t) {
             DriverInput input{t < 3 || (t > 4.3 && t < 6) || t > 7 ? 20.0 : t > 6 ? -10.0 : 0.0};
             input.clutch_nm = t < 3 ? 1e9 : t < 4 ? 0 : t < 4.3 ? ramp(t, 4, 4.3, 10, 120) : 1e9;
             return input;
         }},
        {"crawling, shaft about its kink", 900, 36, 2, 62, {0.07},
         [](double t) { return DriverInput{0.07 * 48 + 5.3 + 3 * std::sin(2 * kPi * 1.5 * t) + 2 * std::sin(2 * kPi * 0.13 * t)}; }}};
    return list;
}

DriveFigures run_manoeuvre(const Manoeuvre &m, DriveCase drive) {
    drive.real.ratios = drive.believed.ratios = m.ratios;
    DriveRig rig(drive);
    rig.start(m.speed_rpm * kRadpsPerRpm, m.shaft_nm);
    rig.count_from(m.counts_from_s);
    while (rig.car().state().time_s < m.duration_s) rig.step(m.driver(rig.car().state().time_s), m.duration_s);
    return rig.figures();
}

} // namespace sixdeg
