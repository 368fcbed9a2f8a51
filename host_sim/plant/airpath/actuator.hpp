// SPDX-License-Identifier: MIT
// A valve or vanes in a position loop: a motor that follows the position sensor's reading.
#pragma once
#include <algorithm>
#include <vector>

#include "plant/airpath/faults.hpp"
#include "plant/airpath/full_data.hpp"

namespace sixdeg::airpath {

/// An offset of the sensor moves the true position by as much, once the loop has followed: the reading then agrees with the
/// command again. Stuck and slow leave the reading true.
class Actuator {
  public:
    Actuator(const ActuatorData &data, int place) : data_(data), place_(place) {}

    void start(double command) { position_ = command, speed_ = 0, offset_ = 0; }

    void step(double t_s, double dt_s, double command, const std::vector<Fault> &faults) {
        offset_ = offset_at(faults, place_, t_s);
        if (find_fault(faults, place_, FaultKind::stuck, t_s)) {
            speed_ = 0;
            return;
        }
        const Fault *slow = find_fault(faults, place_, FaultKind::slow, t_s);
        const double share = slow ? slow->size : 1, w = data_.frequency_radps * share, rate = data_.rate_per_s * share;
        speed_ += dt_s * (w * w * (command + offset_ - position_) - 2 * data_.damping * w * speed_);
        speed_ = std::clamp(speed_, -rate, rate);
        position_ += dt_s * speed_;
        if (position_ < 0 || position_ > 1) position_ = std::clamp(position_, 0.0, 1.0), speed_ = 0;
    }

    double position() const { return position_; }           ///< True.
    double reading() const { return position_ - offset_; }  ///< Of the sensor, before noise.

  private:
    ActuatorData data_;
    int place_;
    double position_ = 0, speed_ = 0, offset_ = 0;
};

} // namespace sixdeg::airpath
