// SPDX-License-Identifier: MIT
#include "plant/vehicle/car_behind.hpp"

namespace sixdeg {

CarBehind::CarBehind(const VehicleSetup &setup, RandomStream wheel_noise)
    : setup_(setup), car_(setup.car, nullptr), teeth_({std::max(setup.wheel_teeth, 1), 0, setup.wheel_jitter_rad, {}}, wheel_noise) {}

void CarBehind::start(double speed_radps, double crank_nm) {
    for (std::size_t g = 0; g < setup_.gear; ++g) car_.set_gear(g + 1);
    car_.start_rolling(speed_radps, crank_nm / car_.ratio());
    car_.drive(speed_radps, 0);
    load_nm_ = car_.crank_load_nm();
}

double CarBehind::capacity_nm(double time_s) const {
    const auto closing = [&](double open_s, double close_s) {
        if (time_s < open_s) return kCarriesNm;
        if (time_s < close_s) return 0.0;
        return kCarriesNm * std::clamp((time_s - close_s) / kCloseS, 0.0, 1.0);
    };
    double least = kCarriesNm;
    for (const GearShift &shift : setup_.shifts) least = std::min(least, closing(shift.at_s, shift.at_s + kOpenS));
    for (std::size_t i = 0; i + 1 < setup_.open_s.size(); i += 2) least = std::min(least, closing(setup_.open_s[i], setup_.open_s[i + 1]));
    return least;
}

void CarBehind::follow_driver(double time_s) {
    const double capacity = capacity_nm(time_s);
    car_.set_clutch(capacity);
    while (shifted_ < setup_.shifts.size() && time_s >= setup_.shifts[shifted_].at_s + kOpenS / 2) {
        car_.set_gear(setup_.shifts[shifted_++].gear);
    }
    holds_ = capacity >= kCarriesNm && !car_.slips();
}

void CarBehind::step(double from_s, double from_radps, double to_s, double to_radps, std::optional<double> brake_nm) {
    follow_driver(from_s);
    const double slope = (to_radps - from_radps) / (to_s - from_s);
    while (to_s - car_.state().time_s > 1e-12) {
        car_.drive(from_radps + slope * (car_.state().time_s - from_s), slope);
        car_.set_extra_load(brake_nm ? *brake_nm / car_.ratio() - car_.road_nm() : setup_.slope_nm.at(from_s));
        car_.step(to_s);
        if (setup_.wheel_teeth == 0) continue;
        const VehicleState &a = car_.before(), &b = car_.state();
        passed_.clear();
        teeth_.pass({a.time_s, a.wheel_rad, a.wheel_radps}, {b.time_s, b.wheel_rad, b.wheel_radps}, passed_);
        edges_.insert(edges_.end(), passed_.begin(), passed_.end());
    }
    const double load = car_.crank_load_nm();
    load_slope_ = (load - load_nm_) / (to_s - from_s);
    load_nm_ = load;
}

} // namespace sixdeg
