// SPDX-License-Identifier: MIT
// How much fuel a demanded load takes: found by running the nominal cylinder itself, once, before a run.
#pragma once
#include <vector>

#include "plant/engine/plant_engine.hpp"

namespace sixdeg {

/// Fuel of one nominal cylinder and cycle over speed and brake mean effective pressure, bilinear between
/// nodes that were solved to 1e-9 of the demanded IMEP (demand plus friction). Demands the trapped air cannot
/// burn are marked.
class FuelMap {
  public:
    /// Nodes span [speed_low, speed_high] in rad/s and [0, bmep_top] in Pa.
    FuelMap(const PlantEngine &engine, double speed_low_radps, double speed_high_radps, double bmep_top_pa);

    /// kg; speed and demand are clamped to the nodes' span.
    double fuel_kg(double speed_radps, double bmep_pa) const {
        return interpolate(fuel_, speed_radps, bmep_pa);
    }
    /// Net IMEP without fuel (negative: pumping and wall loss), Pa.
    double motored_imep_pa(double speed_radps, double bmep_pa) const {
        return interpolate(motored_, speed_radps, bmep_pa);
    }
    /// Whether the trapped air burns the fuel of the highest demand at every speed node.
    bool reaches_top() const { return reaches_; }

    /// Largest demand that the trapped air can burn at this speed, Pa, to 1 %; at most `limit_pa`.
    static double largest_bmep_pa(const PlantEngine &engine, double speed_radps, double limit_pa);

  private:
    static constexpr int kLoads = 6;
    double interpolate(const std::vector<double> &table, double speed_radps, double bmep_pa) const;
    double speed_low_, speed_span_, bmep_top_;
    int speeds_;                         // 1 when there is but one speed
    std::vector<double> fuel_, motored_; // [speeds_][kLoads]
    bool reaches_ = true;
};

} // namespace sixdeg
