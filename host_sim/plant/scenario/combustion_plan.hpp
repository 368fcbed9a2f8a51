// SPDX-License-Identifier: MIT
// What each combustion is to be: cyclic variation and misfires, drawn when the intake valve closes.
#pragma once
#include <vector>

#include "common/random.hpp"
#include "plant/engine/engine_model.hpp"
#include "plant/scenario/scenario.hpp"

namespace sixdeg {

/// Draws charges for one run. Each cylinder has streams of its own, drawn from equally often whatever is
/// switched on.
class CombustionPlan {
  public:
    CombustionPlan(const Scenario &scenario, std::uint64_t seed);

    /// The charge of firing-order entry `lane` for the combustion of `cycle`, injected at time_s, at nominal fuel
    /// `fuel_kg` and demand `bmep_pa`. Call once a cycle for each lane, cycles ascending.
    Charge draw(int lane, std::int64_t cycle, double time_s, double fuel_kg, double bmep_pa);

    /// What a cylinder's injector gives at a time, of what it is told.
    double fuel_factor(int cylinder, double time_s) const;

  private:
    double burned_fraction(int lane, std::int64_t cycle);
    const Scenario &scenario_;
    std::vector<RandomStream> cyclic_, misfire_;
};

} // namespace sixdeg
