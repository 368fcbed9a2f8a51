// SPDX-License-Identifier: MIT
// The car behind the simulated engine: what a scenario's [vehicle] does with the driveline of the engine file.
//
// The engine's step comes first, with the shaft's torque going on as it did; then the car is taken along the speed that the crank had,
// which is straight in time over a step. The shaft is slow beside a step of half a degree.
#pragma once
#include <deque>
#include <memory>

#include "common/profile.hpp"
#include "plant/vehicle/vehicle_model.hpp"
#include "plant/vehicle/vehicle_teeth.hpp"

namespace sixdeg {

/// Another gear: the clutch opens, is open for kOpenS, and carries all again after kCloseS more.
struct GearShift {
    double at_s;
    std::size_t gear; ///< From 0.
};

/// What happens to the car in a run.
struct VehicleSetup {
    Driveline car;                   ///< As it really is.
    std::size_t gear = 0;            ///< At the start, from 0.
    std::vector<GearShift> shifts;   ///< Ascending.
    std::vector<double> open_s;      ///< Pairs from, to: the clutch is open.
    Profile slope_nm{0.0};           ///< Load at the wheels beside the road's resistance, over time.
    bool tell_gear = true;           ///< False: nobody tells the controller which gear is in.
    int wheel_teeth = 0;             ///< 0: none are read.
    double wheel_jitter_rad = 0;
};

class CarBehind {
  public:
    static constexpr double kOpenS = 0.1, kCloseS = 0.3, kCarriesNm = 2000;
    CarBehind(const VehicleSetup &setup, RandomStream wheel_noise);

    /// In equilibrium at a speed of the crank and a torque of the shaft at the crank.
    void start(double speed_radps, double crank_nm);
    /// The engine has turned from one time and speed of its crank to another. `brake_nm`: torque at the crank that stands for all load at
    /// the wheels, the road's resistance included; nothing: the road and the slope load them.
    void step(double from_s, double from_radps, double to_s, double to_radps, std::optional<double> brake_nm);

    double crank_load_nm() const { return car_.crank_load_nm(); }
    double load_slope_nmps() const { return load_slope_; }
    double crank_radps_of_wheels() const { return car_.state().wheel_radps / car_.ratio(); }
    double inertia_at_crank_kgm2() const { return setup_.car.vehicle_inertia_kgm2 * car_.ratio() * car_.ratio(); }
    /// What the controller knows: the gear, from 1, while the clutch holds; 0 otherwise.
    int gear() const { return holds_ && setup_.tell_gear ? int(car_.gear()) + 1 : 0; }
    const VehicleModel &model() const { return car_; }
    std::deque<ToothEdge> &wheel_edges() { return edges_; }

  private:
    double capacity_nm(double time_s) const;
    void follow_driver(double time_s);

    VehicleSetup setup_;
    VehicleModel car_;
    VehicleTeeth teeth_;
    std::size_t shifted_ = 0;
    double load_nm_ = 0, load_slope_ = 0;
    bool holds_ = true;
    std::deque<ToothEdge> edges_;
    std::vector<ToothEdge> passed_;
};

} // namespace sixdeg
