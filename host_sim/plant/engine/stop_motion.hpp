// SPDX-License-Identifier: MIT
// The last moments of an engine that stops: it rocks on its compressed cylinders and comes to rest.
#pragma once
#include <vector>

#include "plant/engine/engine_model.hpp"

namespace sixdeg {

/// Integrates over time, since the crank may turn back. Cylinders closed at the stall are gas springs
/// (polytropic, exponent 1.3) that leak to crankcase pressure within 0.15 s; open ones push nothing; friction
/// is Coulomb's; the load is gone. docs/theory/plant.md, section Stopping.
class StopMotion {
  public:
    /// Takes over where `model` refused its next step.
    StopMotion(const PlantEngine &engine, const std::vector<CylinderSpread> &spread,
               const EngineModel &model);

    /// One step of 0.1 ms. False once the crank rests.
    bool step();
    double angle_rad() const { return angle_; }
    double time_s() const { return time_; }
    double speed_radps() const { return speed_; }

  private:
    struct Spring {
        CrankSlider slider;
        double tdc_rad, pressure_pa; // pressure at the volume now
    };
    double gas_torque_nm() const;
    std::vector<Spring> springs_;
    double inertia_, friction_nm_, crankcase_pa_, angle_, time_, speed_;
};

} // namespace sixdeg
