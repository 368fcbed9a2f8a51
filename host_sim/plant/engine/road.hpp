// SPDX-License-Identifier: MIT
// Rough road: a random torque that reaches the crank through the wheels.
#pragma once
#include <array>

#include "common/profile.hpp"
#include "common/random.hpp"

namespace sixdeg {

/// Band noise of given rms: 32 sines, one at a random place in each of 32 equal parts of the band, with
/// random phases, straight between samples 1 ms apart. Its rms over a long time is `rms_nm` (exact before the
/// straight pieces, which lose less than 0.1 % below 15 Hz). The same seed gives the same road.
class RoughRoad {
  public:
    RoughRoad(double rms_nm, double low_hz, double high_hz, RandomStream random);
    /// The straight piece that holds at t >= 0, N m.
    Profile::Segment segment(double t) const;

  private:
    static constexpr int kSines = 32;
    static constexpr double kPeriod = 1e-3;
    double at(double t) const;
    double amplitude_nm_;
    std::array<double, kSines> frequency_radps_{}, phase_{};
};

} // namespace sixdeg
