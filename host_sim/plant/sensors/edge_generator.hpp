// SPDX-License-Identifier: MIT
// Edges of a wheel that turns as told: no engine, only a speed profile. For decoders, fuzzing and long runs.
#pragma once
#include "plant/sensors/pickup.hpp"
#include "plant/sensors/wheel_edges.hpp"

namespace sixdeg {

/// Crank angle over time as the speed profile says, piecewise quadratic, so every crossing time is a closed
/// form (docs/theory/plant.md, section Encoder). Speed may be negative (the crank turns back) or zero.
class EdgeGenerator {
  public:
    /// `speed_rpm` over time in s; the crank stands at `start_deg` (as ENGINE.toml counts) at time 0.
    EdgeGenerator(const EngineFile &engine, const EncoderFaults &faults, const Profile &speed_rpm,
                  double start_deg, double duration_s, std::uint64_t seed);

    /// Next edge in order of time; false at the end of the run. Torques in `edge` are 0.
    bool next_edge(EncoderEdge &edge);

    const WheelEdges &wheel() const { return wheel_; }

  private:
    struct Piece { // of constant acceleration and one direction
        double t0, t1, angle0_deg, speed_dps, slope_dps2;
        double angle(double dt) const { return angle0_deg + dt * (speed_dps + dt * slope_dps2 / 2); }
        double speed(double dt) const { return speed_dps + dt * slope_dps2; }
        /// Time after t0 at which the crank has turned by `turn_deg`; infinite if it never does.
        double time_of(double turn_deg) const;
    };

    void begin_piece(double t, double angle_deg);
    bool pass_next();
    double cam_time() const;
    void pass(double dt, EdgeKind kind, const WheelEdge *tooth);

    Profile speed_dps_;
    double duration_s_;
    EncoderFaults faults_;
    WheelEdges wheel_;
    Pickup pickup_;
    bool has_cam_;
    double next_cam_deg_;
    Piece piece_{};
    double now_s_ = 0, now_radps_ = 0; // all passings up to here are known
    bool backward_ = false, ended_ = false;
};

} // namespace sixdeg
