// SPDX-License-Identifier: MIT
// The simulated air path of a diesel with exhaust gas recirculation and a variable turbine, as mean values over a cycle: fourteen
// states of gas, wall and shaft with the two actuators beside them, against the four of document 001's model. It shares no law and
// no line with an observer. Equations: docs/theory/airpath.md, section Plant.
#pragma once
#include "plant/airpath/full_data.hpp"

namespace sixdeg::airpath {

/// What acts on the air path.
struct Drive {
    double speed_radps = 0; ///< Crank, above 0.
    double fuel_kgps = 0;   ///< Of all cylinders.
    double egr = 0, vgt = 0; ///< True positions, 0 closed to 1 open.
    double leak_m2 = 0;      ///< Effective area of a hole in the intake manifold.
};

struct State {
    double boost_kg = 0, boost_j = 0;                     ///< Behind the compressor: cooled gas.
    double air_kg = 0, egr_kg = 0, intake_j = 0;          ///< Intake manifold.
    double exhaust_kg = 0, exhaust_j = 0, wall_k = 0;     ///< Exhaust manifold.
    double leaving_kgps = 0, leaving_k = 0;               ///< Gas of the cylinders, a cycle late.
    double egr_k = 0;                                     ///< Behind the EGR cooler.
    double turbo_radps = 0;
};

/// What the state and the drive make of each other.
struct Flows {
    double compressor_kgps = 0, charge_kgps = 0, egr_kgps = 0, cylinder_kgps = 0, turbine_kgps = 0, leak_kgps = 0;
    double leaving_kgps = 0; ///< Out of the cylinders, three strokes late.
    double boost_pa = 0, intake_pa = 0, exhaust_pa = 0;
    double behind_pa = 0;         ///< The turbine.
    double isentropic_rise_k = 0; ///< Of a compressor without losses.
    double charge_k = 0, intake_k = 0, exhaust_k = 0; ///< Behind the charge-air cooler, in both manifolds.
};

class FullModel {
  public:
    /// `displacement_m3` of all cylinders.
    FullModel(const FullData &data, double displacement_m3, double compression_ratio);

    /// Settles at a constant drive.
    void start(const Drive &drive);
    /// Over dt_s, at most 1 ms, with the drive held.
    void step(const Drive &drive, double dt_s);

    const State &state() const { return state_; }
    const Flows &flows() const { return flows_; } ///< At the end of the last step.
    const FullData &data() const { return data_; }

  private:
    Flows flows_at(const State &s, const Drive &drive) const;
    State rates(const State &s, const Drive &drive) const;
    void turbine_and_compressor(const State &s, const Flows &f, double &turbine_w, double &compressor_w, double &compressor_out_k) const;

    FullData data_;
    double displacement_m3_, compression_ratio_;
    State state_;
    Flows flows_;
};

} // namespace sixdeg::airpath
