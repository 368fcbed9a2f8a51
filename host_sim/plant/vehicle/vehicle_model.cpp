// SPDX-License-Identifier: MIT
#include "plant/vehicle/vehicle_model.hpp"

namespace sixdeg {
namespace {

constexpr double kLeastS = 1e-6; // of a step at whose end the clutch locks
constexpr int kHalvings = 50; // of the step in which something changes: below 1e-18 s

VehicleState plus(const VehicleState &a, double h, const VehicleState &slope) {
    return {a.time_s + h,
            a.angle_rad + h * slope.angle_rad,
            a.speed_radps + h * slope.speed_radps,
            a.gearbox_radps + h * slope.gearbox_radps,
            a.twist_rad + h * slope.twist_rad,
            a.wheel_radps + h * slope.wheel_radps,
            a.wheel_rad + h * slope.wheel_rad};
}

} // namespace

VehicleModel::VehicleModel(const Driveline &driveline, std::function<double(double, double)> torque_nm, double step_s,
                           double gearbox_inertia_kgm2)
    : driveline_(driveline), torque_nm_(std::move(torque_nm)), step_s_(step_s), gearbox_kgm2_(gearbox_inertia_kgm2) {}

void VehicleModel::start(const VehicleState &state) {
    state_ = before_ = state;
    slips_ = state.gearbox_radps != state.speed_radps;
    slip_sign_ = state.speed_radps > state.gearbox_radps ? 1 : -1;
    location_ = driveline_.location(state.twist_rad);
    changes_.clear();
}

void VehicleModel::start_rolling(double speed_radps, double shaft_nm) {
    VehicleState at;
    at.speed_radps = at.gearbox_radps = speed_radps;
    at.wheel_radps = ratio() * speed_radps;
    at.twist_rad = driveline_.twist_rad(shaft_nm);
    start(at);
}

void VehicleModel::drive(double speed_radps, double slope_radps2) {
    driven_ = true;
    driven_slope_ = slope_radps2;
    state_.speed_radps = speed_radps;
    if (!slips_) state_.gearbox_radps = speed_radps;
}

double VehicleModel::crank_load_nm() const {
    // While it slips the gearbox's input does not turn with the crank, though the engine counts it in.
    return slips_ ? slip_sign_ * capacity_nm_ - gearbox_kgm2_ * driven_slope_ : ratio() * shaft_nm();
}

void VehicleModel::set_gear(std::size_t gear) {
    const double wheels = ratio() * state_.gearbox_radps;
    gear_ = gear;
    state_.gearbox_radps = wheels / ratio();
    slips_ = true;
    slip_sign_ = state_.speed_radps > state_.gearbox_radps ? 1 : -1;
}

double VehicleModel::shaft_nm() const {
    return driveline_.spring_nm(state_.twist_rad, location_) +
           driveline_.damping_nms * (ratio() * state_.gearbox_radps - state_.wheel_radps);
}

// By the laws of the present location and of a clutch that slips or holds, wherever `at` is.
VehicleState VehicleModel::slope(const VehicleState &at) const {
    const double gearbox = slips_ ? at.gearbox_radps : at.speed_radps;
    const double winding = ratio() * gearbox - at.wheel_radps;
    const double shaft = driveline_.spring_nm(at.twist_rad, location_) + driveline_.damping_nms * winding;
    VehicleState slope;
    slope.angle_rad = at.speed_radps;
    const double engine = driven_ ? 0 : torque_nm_(at.time_s, at.angle_rad) - driveline_.engine_viscous_nms * at.speed_radps;
    if (slips_) {
        const double clutch = slip_sign_ * capacity_nm_;
        slope.speed_radps = (engine - clutch) / (driveline_.engine_inertia_kgm2 - gearbox_kgm2_);
        slope.gearbox_radps = (clutch - ratio() * shaft) / gearbox_kgm2_;
    } else {
        slope.gearbox_radps = slope.speed_radps = (engine - ratio() * shaft) / driveline_.engine_inertia_kgm2;
    }
    if (driven_) {
        slope.speed_radps = driven_slope_;
        if (!slips_) slope.gearbox_radps = driven_slope_;
    }
    slope.twist_rad = winding;
    slope.wheel_radps = (shaft - driveline_.road_nm(at.wheel_radps) - extra_nm_) / driveline_.vehicle_inertia_kgm2;
    slope.wheel_rad = at.wheel_radps;
    return slope;
}

VehicleState VehicleModel::advanced(double h) const {
    const VehicleState k1 = slope(state_), k2 = slope(plus(state_, h / 2, k1)), k3 = slope(plus(state_, h / 2, k2)),
                       k4 = slope(plus(state_, h, k3));
    VehicleState to = plus(plus(plus(state_, h / 6, k1), h / 3, k2), h / 3, k3);
    to = plus(to, h / 6, k4);
    to.time_s = state_.time_s + h;
    return to;
}

// What the clutch must carry to hold.
double VehicleModel::held_nm(const VehicleState &at) const {
    const double winding = ratio() * at.speed_radps - at.wheel_radps;
    const double shaft = driveline_.spring_nm(at.twist_rad, location_) + driveline_.damping_nms * winding;
    if (driven_) return gearbox_kgm2_ * driven_slope_ + ratio() * shaft;
    const double engine = torque_nm_(at.time_s, at.angle_rad) - driveline_.engine_viscous_nms * at.speed_radps;
    const double free = driveline_.engine_inertia_kgm2 - gearbox_kgm2_;
    return engine - free * (engine - ratio() * shaft) / driveline_.engine_inertia_kgm2;
}

bool VehicleModel::leaves(const VehicleState &at) const { return driveline_.location(at.twist_rad) != location_; }

bool VehicleModel::locks(const VehicleState &at) const {
    return slips_ && capacity_nm_ > 0 && slip_sign_ * (at.speed_radps - at.gearbox_radps) <= 0;
}

void VehicleModel::settle_clutch() {
    const double held = held_nm(state_);
    const bool holds = std::abs(held) <= capacity_nm_;
    if (slips_ && locks(state_)) {
        state_.gearbox_radps = state_.speed_radps;
        slips_ = !holds;
        slip_sign_ = held > 0 ? 1 : -1;
        clutch_events_ += slips_ ? 0 : 1;
    } else if (!slips_ && !holds) {
        slips_ = true;
        slip_sign_ = held > 0 ? 1 : -1;
        clutch_events_++;
    }
}

void VehicleModel::step(double until_s) {
    settle_clutch();
    before_ = state_;
    const double h = std::min(step_s_, until_s - state_.time_s);
    VehicleState to = advanced(h);
    const bool changes = leaves(to), locks_now = locks(to);
    if (changes || locks_now) {
        double low = 0, high = h;
        for (int i = 0; i < kHalvings && high - low > 0; ++i) {
            const double middle = (low + high) / 2;
            const VehicleState at = advanced(middle);
            (leaves(at) || locks(at) ? high : low) = middle;
            if (middle == low && middle == high) break;
        }
        // A clutch that can neither hold nor slip for long goes on by a little, so that time does.
        to = advanced(locks_now ? std::max(high, std::min(h, kLeastS)) : high);
    }
    state_ = to;
    const Location now = driveline_.location(state_.twist_rad);
    if (now != location_) {
        changes_.push_back({state_.time_s, location_, now});
        location_ = now;
    }
}

} // namespace sixdeg
