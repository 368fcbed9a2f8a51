// SPDX-License-Identifier: MIT
#include "plant/engine/stop_motion.hpp"

#include <cmath>

namespace sixdeg {
namespace {

constexpr double kStep = 1e-4, kExponent = 1.3, kLeak = 0.15;

} // namespace

StopMotion::StopMotion(const PlantEngine &engine, const std::vector<CylinderSpread> &spread,
                       const EngineModel &model)
    : inertia_(model.tables().inertia[std::size_t(2 * model.step_in_cycle())]),
      friction_nm_(engine.torque_of_mep_nm(engine.fmep_at_pa(0))),
      crankcase_pa_(engine.crankcase_pressure_pa), angle_(model.truth().angle_rad),
      time_(model.truth().time_s), speed_(model.truth().speed_radps) {
    for (std::size_t lane = 0; lane < spread.size(); ++lane) {
        const double tdc = model.tables().tdc_rad[lane], after = std::remainder(angle_ - tdc, 4 * kPi);
        // Closed from intake closing, a turn before exhaust opening.
        if (after < engine.intake_close_rad - 4 * kPi || after > engine.exhaust_open_rad) continue;
        springs_.push_back(
            {engine.slider(spread[lane].compression_ratio), tdc, model.pressure_pa(int(lane))});
    }
}

double StopMotion::gas_torque_nm() const {
    double torque = 0;
    for (const Spring &s : springs_)
        torque += (s.pressure_pa - crankcase_pa_) * s.slider.volume_slope_m3(angle_ - s.tdc_rad);
    return torque;
}

// Semi-implicit Euler: speed first, then angle with the new speed, which keeps a spring's energy bounded.
bool StopMotion::step() {
    const double gas = gas_torque_nm();
    if (speed_ == 0 && std::abs(gas) <= friction_nm_) return false;
    const double direction = speed_ != 0 ? std::copysign(1.0, speed_) : std::copysign(1.0, gas);
    const double before = speed_;
    speed_ += kStep * (gas - direction * friction_nm_) / inertia_;
    // Friction stops the crank; it does not push it back.
    if (before * speed_ < 0) speed_ = 0;
    const double from = angle_;
    angle_ += kStep * speed_;
    time_ += kStep;
    for (Spring &s : springs_) {
        const double ratio = s.slider.volume_m3(from - s.tdc_rad) / s.slider.volume_m3(angle_ - s.tdc_rad);
        s.pressure_pa *= std::pow(ratio, kExponent);
        s.pressure_pa += kStep / kLeak * (crankcase_pa_ - s.pressure_pa);
    }
    return true;
}

} // namespace sixdeg
