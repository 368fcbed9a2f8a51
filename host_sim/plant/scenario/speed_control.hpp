// SPDX-License-Identifier: MIT
// Holds the speed from cycle to cycle, by the brake or by the fuel.
#pragma once

namespace sixdeg {

/// Proportional and integral control of the crank's kinetic energy, once every 720 deg. Energy, not speed: a
/// constant torque changes it by the same amount in every cycle, so one pair of gains fits every speed, load
/// and engine.
class SpeedControl {
  public:
    /// Gains per cycle: 1 would remove the whole error in one cycle.
    SpeedControl(double proportional, double integral) : proportional_(proportional), integral_(integral) {}

    /// Torque to add to the brake (or to take from the engine), N m, held for the coming cycle.
    /// `energy_error_j` is the mean kinetic energy over the cycle just ended less the wanted one.
    double update(double energy_error_j) {
        const double torque = energy_error_j / kCycleRad;
        sum_nm_ += integral_ * torque;
        return sum_nm_ + proportional_ * torque;
    }

    static constexpr double kCycleRad = 12.566370614359172; // 4 pi

  private:
    double proportional_, integral_, sum_nm_ = 0;
};

} // namespace sixdeg
