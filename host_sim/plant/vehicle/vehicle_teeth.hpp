// SPDX-License-Identifier: MIT
// Toothed wheels on the vehicle: when each tooth passes, found within a step, with the faults of a real wheel.
#pragma once
#include <vector>

#include "common/random.hpp"

namespace sixdeg {

struct ToothedWheel {
    int positions = 60;
    int missing = 2;            ///< The last so many positions have no tooth.
    double jitter_rad = 0;      ///< Of each edge anew, standard deviation, of the wheel's own angle.
    std::vector<double> pattern_rad; ///< Of each position for good; empty: none.
};

/// One edge.
struct ToothEdge {
    double time_s;    ///< As captured: pattern and jitter are in it.
    int position;     ///< [0, positions).
    int advance;      ///< Positions since the last edge.
};

/// Follows a wheel from step to step. Time over angle within a step is the cubic through both ends' times and slownesses.
class VehicleTeeth {
  public:
    VehicleTeeth(const ToothedWheel &wheel, RandomStream noise) : wheel_(wheel), noise_(noise) {}

    struct Point {
        double time_s, angle_rad, speed_radps;
    };
    /// Appends to `edges` those that pass between two points; angle and both speeds ascend.
    void pass(const Point &from, const Point &to, std::vector<ToothEdge> &edges);

  private:
    ToothedWheel wheel_;
    RandomStream noise_;
    long next_ = 1; ///< Position that passes next, counted over all revolutions.
    int advance_ = 1;
};

} // namespace sixdeg
