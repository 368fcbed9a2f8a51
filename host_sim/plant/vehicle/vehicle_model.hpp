// SPDX-License-Identifier: MIT
// The simulated vehicle: crank, clutch, gearbox, a shaft of piecewise stiffness, and the car's mass.
//
//   clutch holds:  Je wc' = T - Be wc - ratio S,                 the gearbox turns with the crank
//   clutch slips:  (Je - Jg) wc' = T - Be wc - C,  Jg wg' = C - ratio S,   C = +- what the clutch carries
//   shaft:         twist' = ratio wg - wp,  S = spring(twist) + damping twist'
//   car:           Jv wp' = S - road(wp)
//
// Classical Runge-Kutta in fixed steps of time. Where the shaft changes its location or the clutch begins to hold, the step is
// cut at that moment, so that no step goes over a kink; where each fell is kept. It shares no code with the observers.
#pragma once
#include <functional>
#include <vector>

#include "common/driveline.hpp"

namespace sixdeg {

struct VehicleState {
    double time_s = 0;
    double angle_rad = 0;     ///< Of the crank.
    double speed_radps = 0;   ///< Of the crank.
    double gearbox_radps = 0; ///< Of the gearbox's input; the crank's while the clutch holds.
    double twist_rad = 0;     ///< Of the shaft, at the wheels.
    double wheel_radps = 0;
    double wheel_rad = 0;     ///< Angle of the wheels.
};

/// A change of the shaft's location.
struct LocationChange {
    double time_s;
    Location from, to;
};

class VehicleModel {
  public:
    /// `torque_nm` of the engine at a time and an angle of the crank. gearbox_inertia_kgm2 is part of the engine's and turns alone while
    /// the clutch slips: above 0 and below it. step_s is the longest step.
    VehicleModel(const Driveline &driveline, std::function<double(double time_s, double angle_rad)> torque_nm, double step_s = 1e-4,
                 double gearbox_inertia_kgm2 = 0.02);

    void start(const VehicleState &state);
    /// In equilibrium at a torque of the shaft: the torsion that goes with it, and no movement of it.
    void start_rolling(double speed_radps, double shaft_nm);

    /// What the clutch carries from now on, N m at the crank: 0 is open. Where it is less than what goes through it, it slips.
    void set_clutch(double capacity_nm) { capacity_nm_ = capacity_nm; }
    /// Another gear, while the clutch slips: the synchroniser takes the gearbox to the speed that keeps the shaft's movement.
    void set_gear(std::size_t gear);
    /// The crank turns so from now on, whatever the torques: its engine is simulated elsewhere, and takes crank_load_nm().
    void drive(double speed_radps, double slope_radps2);
    /// Torque beside the road's resistance, N m at the wheels: a slope, the brakes.
    void set_extra_load(double load_nm) { extra_nm_ = load_nm; }

    /// One step, at most to `until_s`.
    void step(double until_s);

    const VehicleState &state() const { return state_; }
    const VehicleState &before() const { return before_; } ///< At the start of the last step.
    Location location() const { return location_; }
    bool slips() const { return slips_; }
    std::size_t gear() const { return gear_; }
    double ratio() const { return driveline_.ratios[gear_]; }
    double shaft_nm() const;                                                ///< Spring and damping.
    double road_nm() const { return driveline_.road_nm(state_.wheel_radps); }                 ///< At the wheels, without the extra.
    /// What the engine feels of all this, N m at the crank, when the gearbox's input is part of its inertia.
    double crank_load_nm() const;
    double load_nm() const { return driveline_.road_nm(state_.wheel_radps) + extra_nm_; }
    const std::vector<LocationChange> &changes() const { return changes_; } ///< Since the start.
    int clutch_events() const { return clutch_events_; }                    ///< How often it began to slip or to hold.

  private:
    VehicleState slope(const VehicleState &at) const;
    VehicleState advanced(double step_s) const;
    double clutch_nm(const VehicleState &at) const;
    double held_nm(const VehicleState &at) const;
    bool leaves(const VehicleState &at) const;
    bool locks(const VehicleState &at) const;
    void settle_clutch();

    Driveline driveline_;
    std::function<double(double, double)> torque_nm_;
    double step_s_, gearbox_kgm2_;
    double capacity_nm_ = 1e9, extra_nm_ = 0;
    std::size_t gear_ = 0;
    Location location_ = 2;
    bool slips_ = false, driven_ = false;
    double driven_slope_ = 0;
    double slip_sign_ = 1;
    int clutch_events_ = 0;
    VehicleState state_, before_;
    std::vector<LocationChange> changes_;
};

} // namespace sixdeg
