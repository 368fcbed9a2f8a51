// SPDX-License-Identifier: MIT
// The engine on the bench: a scenario's engine, load, speed control and encoder as one source of timed edges.
//
//     Plant plant(scenario, scenario.seed);
//     EncoderEdge edge;
//     CycleTruth cycle;
//     while (plant.next_edge(edge)) {
//         firmware(edge.tick, edge.kind);                  // the firmware sees no more than this
//         teeth.write(edge);                               // truth goes its own way
//         while (plant.next_cycle(cycle)) cycles.write(cycle);
//     }
#pragma once
#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "plant/airpath/air_path.hpp"
#include "plant/engine/engine_model.hpp"
#include "plant/engine/fuel_map.hpp"
#include "plant/engine/road.hpp"
#include "plant/engine/stop_motion.hpp"
#include "plant/engine/torsion.hpp"
#include "plant/exhaust/exhaust_model.hpp"
#include "plant/scenario/combustion_plan.hpp"
#include "plant/scenario/scenario.hpp"
#include "plant/scenario/speed_control.hpp"
#include "plant/sensors/wheel_edges.hpp"

namespace sixdeg {

/// One run. The same scenario and seed give the same bits. Instances share nothing; a Plant is neither copied
/// nor moved.
class Plant {
  public:
    /// Turns the engine two cycles at the scenario's first speed, so that time 0 begins in running order.
    /// Throws InputError when the demanded load is beyond the engine.
    Plant(const Scenario &scenario, std::uint64_t seed);
    Plant(const Plant &) = delete;
    Plant &operator=(const Plant &) = delete;

    /// Next edge in order of time. False at the end of the run, or when the engine has stalled and come to
    /// rest: it rocks on its compressed cylinders first, and gives the edges of that, some of them backward.
    bool next_edge(EncoderEdge &edge);
    /// Next cylinder cycle that is complete, in order of completion: 360 deg after its firing TDC. False if
    /// none waits.
    bool next_cycle(CycleTruth &cycle);

    /// Next sample of the wideband sensor taken before time_s. False if none waits; none ever without scenario.uego.
    bool next_uego(double time_s, UegoSample &sample);
    /// The same of the pressure in the exhaust manifold.
    bool next_exhaust_pressure(double time_s, PressureSample &sample);
    /// The same of the air path's sensors, with what is true then; none ever without scenario.air_path.
    bool next_air_path(double time_s, airpath::Readings &readings, airpath::Truth &truth) {
        return air_path_ && air_path_->next(time_s, readings, &truth);
    }

    /// Next edge of a driven wheel that passed before time_s. False if none waits; none ever without scenario.vehicle.
    bool next_wheel_edge(double time_s, double &edge_s);
    const CarBehind *car() const { return car_ ? &*car_ : nullptr; }

    /// The crank at the end of the last step taken; up to a tooth ahead of the last edge handed out. Holds
    /// its last value once the engine has stalled.
    const StepTruth &truth() const { return model_.truth(); }
    /// Appends every step from now on to `sink` (caller-owned, outlives the plant); nullptr ends it.
    void record_steps(std::vector<StepTruth> *sink) { step_sink_ = sink; }
    /// Calls back after every step from now on, the exhaust included.
    void watch_steps(std::function<void()> watcher) { watcher_ = std::move(watcher); }
    /// Factor on the fuel of a physical cylinder from its next intake closing on, for closed loops. [0, 2].
    void set_fuel_trim(int cylinder, double factor);
    /// Manifold pressure, Pa, that every nominal cylinder breathes now.
    double intake_pressure_pa() const {
        return air_path_ ? air_path_->intake_pa() : scenario_.engine.intake_pressure_pa.at(demand_pa_);
    }
    /// Fuel commanded at the last intake closing, kg a stroke, before trims and spread.
    double commanded_fuel_kg() const { return commanded_fuel_kg_; }
    /// What the injector of a physical cylinder gives now, of what it is told.
    double injector_factor(int cylinder) const { return plan_.fuel_factor(cylinder, model_.truth().time_s); }
    bool stalled() const { return stop_.has_value(); }
    const EngineModel &model() const { return model_; }
    const exhaust::ExhaustModel *exhaust() const { return exhaust_ ? &*exhaust_ : nullptr; }
    /// lambda as the sensor feels it, before noise and sampling; 0 without one.
    double uego_lambda() const { return uego_ ? uego_->lambda() : 0; }
    const WheelEdges &wheel() const { return wheel_; }

  private:
    struct SensorPoint { // where the toothed wheel is
        double angle_deg, time_s, speed_radps;
    };
    void pre_roll();
    void fill_intake();
    void advance();
    void handle_events();
    void step_exhaust(double dt_s);
    airpath::EngineDrive air_drive(double fuel_kg) const;
    void set_charge(const Event &event);
    void control();
    void refresh_speed_and_load();
    void step_car();
    void advance_stop();
    void find_edges(const StepTruth &before, const SensorPoint &from);
    void find_backward_edges(const StepTruth &before, const SensorPoint &from);
    void pass(double angle_deg, const StepTruth &before, const SensorPoint &from, EdgeKind kind, int tooth);
    SensorPoint sensor() const;
    bool fuel_is_cut(double time_s) const;
    bool at_end() const;

    Scenario scenario_;
    EngineModel model_;
    FuelMap fuel_map_;
    Profile load_nm_; // in governor and free
    CombustionPlan plan_;
    SpeedControl control_;
    RoughRoad road_;
    CrankElasticity torsion_;
    std::optional<CarBehind> car_;
    WheelEdges wheel_;
    Pickup pickup_;
    std::optional<exhaust::ExhaustModel> exhaust_;
    std::optional<exhaust::Uego> uego_;
    std::deque<UegoSample> uego_samples_;
    std::optional<exhaust::PressureSensor> exhaust_pressure_;
    std::deque<PressureSample> pressure_samples_;
    std::optional<airpath::AirPath> air_path_;
    SensorPoint sensor_{};
    std::array<double, kMaxCylinders> fuel_trim_{};
    double next_cam_deg_ = 0, earliest_cam_deg_ = 0, end_angle_rad_ = 1e300, next_control_rad_ = 0, control_time_ = 0;
    double mean_speed_ = 0, brake_nm_ = 0, demand_pa_ = 0, commanded_fuel_kg_ = 0,
           refresh_at_s_ = 0;
    int steps_to_tdc_ = 0;
    bool running_ = false, ended_ = false;
    std::optional<StopMotion> stop_;
    bool backward_ = false;
    std::deque<CycleTruth> cycles_;
    std::vector<StepTruth> *step_sink_ = nullptr;
    std::function<void()> watcher_;
};

} // namespace sixdeg
