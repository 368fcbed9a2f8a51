// SPDX-License-Identifier: MIT
// From the turbine to the sensor's tip: plug flow by mass, a mixing volume, a dead time.
#pragma once
#include <algorithm>
#include <cstddef>
#include <deque>

namespace sixdeg::exhaust {

/// Carries one quantity (air fraction) along. What enters when `m` kg have passed leaves when m + pipe_kg
/// have.
class Transport {
  public:
    void start(double value) {
        plug_.assign(1, {0, value});
        late_.assign(1, {-1e300, value});
        passed_kg_ = 0;
        mixed_ = plug_out_ = value;
    }

    /// `flow_kgps` (taken as at least 0) of gas worth `value` enters for dt_s, up to time_s; masses as they
    /// are now.
    void step(double time_s, double dt_s, double flow_kgps, double value, double pipe_kg, double mixing_kg,
              double dead_s) {
        const double moved = std::max(flow_kgps, 0.0) * dt_s;
        passed_kg_ += moved;
        plug_.push_back({passed_kg_, value});
        plug_out_ = take(plug_, passed_kg_ - pipe_kg);
        mixed_ += (plug_out_ - mixed_) * moved / (mixing_kg + moved);
        late_.push_back({time_s, mixed_});
        out_ = take(late_, time_s - dead_s);
    }

    double at_sensor() const { return out_; }

  private:
    struct Parcel {
        double mark, value;
    };
    /// Value of the parcel that stands at `mark`, straight between parcels; forgets those before it.
    static double take(std::deque<Parcel> &line, double mark) {
        while (line.size() > 1 && line[1].mark <= mark) line.pop_front();
        if (line.size() == 1 || mark <= line[0].mark || line[0].mark < -1e299) return line[0].value;
        const double x = (mark - line[0].mark) / (line[1].mark - line[0].mark);
        return line[0].value + x * (line[1].value - line[0].value);
    }

    std::deque<Parcel> plug_, late_;
    double passed_kg_ = 0, plug_out_ = 0, mixed_ = 0, out_ = 0;
};

} // namespace sixdeg::exhaust
