// SPDX-License-Identifier: MIT
// The guard filter on a simulated drive: a car, its driver, teeth with faults, and what the filter made of them.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "design/driveline/guard_design.hpp"
#include "plant/vehicle/vehicle_model.hpp"
#include "plant/vehicle/vehicle_teeth.hpp"
#include "studies/driveline/drive_score.hpp"
#include "studies/driveline/guard_filter.hpp"

namespace sixdeg {

/// The filter believes `believed`; the car is `real`.
struct DriveCase {
    Driveline real, believed;
    GuardBelief belief;
    sd_driveline_guard_by_t guard = SD_GUARD_ANGLE;
    bool fixed_point = false;    ///< The filter in q31.
    double duration_s = 600;
    double jitter_deg = 0.02;
    double pattern_deg = 0;      ///< Standard deviation of a tooth's place.
    bool pattern_known = false;
    double wheel_jitter_deg = 0; ///< Of the wheels' teeth; 0: there are none.
    double torque_error_nm = 0;  ///< Of the torque told, for good.
    double ripple_nm = 0;        ///< Amplitude of the firings, twice a revolution; not told.
    double slope_nm = 0;         ///< Load at the wheels that nobody knows of.
    std::uint64_t seed = 1;
};

/// A car of document 003's size in second gear: canonical driveline, rolling resistance and drag.
DriveCase usual_drive();

/// What the driver does.
struct DriverInput {
    double torque_nm = 0;
    double clutch_nm = 1e9; ///< What the clutch carries; below kClutchHoldsNm the filter is told that no gear is in.
    std::size_t gear = 0;   ///< Changes only while the clutch is open.
};
constexpr double kClutchHoldsNm = 1000;

/// The car with its teeth and the filter on them, step by step.
class DriveRig {
  public:
    explicit DriveRig(const DriveCase &drive);
    void start(double speed_radps, double shaft_nm) { car_.start_rolling(speed_radps, shaft_nm); }
    /// A step of the car, 0.1 ms or less.
    void step(const DriverInput &input, double until_s);
    const VehicleModel &car() const { return car_; }
    const sd_driveline_out_f32_t &out() const { return filter_.out(); }
    const std::vector<ToothEdge> &edges() const { return edges_; } ///< Of the last step.
    /// Of all that came from from_s on.
    DriveFigures figures() const;
    /// A fault: the filter believes in another torsion from now on.
    void put_twist(double twist_rad) { filter_.put_twist(twist_rad); }
    void count_from(double from_s) { score_.count_from(from_s); }

  private:
    void tooth(const ToothEdge &edge, const DriverInput &input);

    DriveCase drive_;
    double input_nm_ = 0;
    VehicleModel car_;
    ToothedWheel wheel_;
    VehicleTeeth crank_teeth_, wheel_teeth_;
    GuardFilter filter_;
    std::vector<ToothEdge> edges_, wheel_edges_;
    DriveScore score_;
    double last_edge_s_ = 0, torque_sum_ = 0, torque_s_ = 0;
};

/// A drive in one gear between 1300 and 2900 rpm: tip-ins and tip-outs of random size every 0.6 to 3 s. `watch` sees the rig after each
/// step.
DriveFigures run_drive(const DriveCase &drive, const std::function<void(const DriveRig &)> &watch = {});

} // namespace sixdeg
