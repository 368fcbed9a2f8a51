// SPDX-License-Identifier: MIT
// The exhaust side of the simulated engine: cylinders that blow down through their valves into runners and
// one manifold, a turbine, exhaust gas recirculation. It runs beside EngineModel, step by step, and takes
// cylinder state when an exhaust valve opens; nothing goes back but the composition of the next charge.
//
// Composition is the air fraction x = (air - s fuel)/(air + fuel) of a gas, lambda of document 004 is 1 - x;
// missing air counts as negative. It is conserved whatever burns, as a wideband sensor sees it.
#pragma once
#include <array>
#include <cmath>

#include "plant/engine/engine_model.hpp"
#include "plant/exhaust/exhaust_gas.hpp"
#include "plant/exhaust/transport.hpp"

namespace sixdeg::exhaust {

/// A well-stirred volume.
struct Zone {
    double kg = 0, joule = 0, air_kg = 0;
    double temperature_k() const { return joule / (kg * kCv); }
    double air_fraction() const { return air_kg / kg; }
};

struct Flows { ///< kg/s, at the angle just reached.
    std::array<double, kMaxCylinders> valve{};
    double turbine = 0, egr = 0;
};

/// What has entered, left and been lost since start(); for the balances.
struct Ledger {
    double in_kg = 0, in_joule = 0, in_air_kg = 0; ///< Cylinders at exhaust opening, and backflow they keep.
    double out_kg = 0, out_joule = 0,
           out_air_kg = 0;                   ///< Turbine, recirculation, and cylinders at exhaust closing.
    double wall_joule = 0, piston_joule = 0; ///< Heat lost, work done on pistons.
};

class ExhaustModel {
  public:
    /// The engine file has [exhaust].
    explicit ExhaustModel(const PlantEngine &engine);

    /// Fills manifold, runners and pipe with gas of the given air fraction, at rest.
    void start(double air_fraction);
    /// A lane's intake valve closed over `trapped_kg`, and fuel follows. Lanes are indices into firing_order.
    void charge(int lane, double trapped_kg, double fuel_kg);
    /// One engine step of dt_s: valves that `model` has just opened, flow, transport.
    void step(const EngineModel &model, double dt_s, double mean_speed_radps, double intake_pa);

    /// lambda of the gas a lane has let out last, or lets out now.
    double lambda_of(int lane) const { return lambda_[std::size_t(lane)]; }
    double pressure_pa() const { return (kGamma - 1) * state_.manifold.joule / setup_.manifold_m3; }
    /// Behind the turbine, where the sensor sits.
    double downstream_pa() const {
        return kAmbientPa + plant_.back_pressure_pa * std::pow(flow_mean_ / plant_.rated_kgps, 2);
    }
    /// Air fraction at the sensor's tip.
    double at_sensor() const { return transport_.at_sensor(); }
    const Zone &manifold() const { return state_.manifold; }
    double turbine_radps() const { return state_.turbine_radps; }
    const Flows &flows() const { return flows_; } ///< In the middle of the last part of the last step.
    const Ledger &ledger() const { return ledger_; }
    Zone held() const; ///< By open cylinders, runners and manifold together.

  private:
    static constexpr double kAmbientPa = 101300;
    struct State {
        std::array<Zone, kMaxCylinders> cylinder{};
        std::array<double, kMaxCylinders> runner_air_kg{};
        Zone manifold;
        double turbine_radps = 0;
    };
    struct Charge {
        double kg = 0, air_kg = 0, rest_kg = 0, rest_air_kg = 0;
        bool open = false;
    };
    struct Passage { ///< Of a lane over one engine step: straight from first to second.
        double volume[2] = {}, area[2] = {};
    };
    void open(int lane, double pressure_pa, double volume_m3);
    void close(int lane);
    void valve_flow(int lane, double x, double step_s, const State &at, State &rate, Flows &flows) const;
    State rates(double x, double step_s, const State &at, Flows &flows, Ledger &ledger) const;
    void substep(double x, double dt, double step_s);
    static void add(State &to, double h, const State &rate);
    double valve_area_m2(double after_tdc_rad) const;

    ExhaustSystem setup_;
    PlantExhaust plant_;
    double stoichiometric_, open_rad_, charge_k_;
    int n_;
    std::vector<double> tdc_rad_;
    State state_;
    std::array<Charge, kMaxCylinders> charge_{};
    std::array<Passage, kMaxCylinders> passage_{};
    std::array<double, kMaxCylinders> runner_kg_{}, lambda_{};
    Flows flows_;
    Ledger ledger_;
    Transport transport_;
    double time_s_ = 0, turbine_area_m2_ = 0, intake_pa_ = 1e5, intake_air_ = 1, flow_mean_ = 0,
           aspirated_kgps_ = 0;
};

} // namespace sixdeg::exhaust
