// SPDX-License-Identifier: MIT
// Twist of the crank: what the toothed wheel does beyond the rigid crank.
#pragma once
#include <vector>

#include "plant/engine/engine_model.hpp"

namespace sixdeg {

/// The first elastic modes of a free chain (front end, throws in physical order, flywheel), driven by each
/// cylinder's gas torque, the torque of its reciprocating mass (-J_i' w^2/2) and the load at the flywheel.
/// One way: the twist moves the wheel but not the pistons, whose angle it would change by less than a degree
/// (docs/theory/plant.md, section Torsion).
class CrankElasticity {
  public:
    explicit CrankElasticity(const PlantEngine &engine);

    bool enabled() const { return !modes_.empty(); }
    /// Carries the modes over one step that lasted `duration_s` and ended at the model's state. The torques
    /// of the step's two ends are averaged; each mode is propagated exactly for that constant torque.
    void step(const EngineModel &model, double duration_s);
    /// Angle and speed of the toothed wheel beyond the rigid crank's, rad and rad/s; 0 without modes.
    double wheel_twist_rad() const { return twist_; }
    double wheel_twist_radps() const { return twist_rate_; }
    /// Natural frequencies of the modes kept, rad/s, ascending.
    std::vector<double> frequencies_radps() const;

  private:
    struct Mode {
        double frequency_radps, wheel_shape, flywheel_shape;
        std::vector<double> throw_shape; // by lane
        double angle = 0, rate = 0;      // modal coordinate, mass-normalised
        double force = 0;                // at the step's start
    };
    double force_of(const Mode &mode, const EngineModel &model) const;
    void propagate(Mode &mode, double force, double duration_s) const;

    std::vector<Mode> modes_;
    std::vector<double> half_inertia_slope_; // [steps][lanes]: J_i'/2, built at the first step
    PlantEngine engine_;
    double twist_ = 0, twist_rate_ = 0;
};

} // namespace sixdeg
