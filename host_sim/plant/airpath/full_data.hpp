// SPDX-License-Identifier: MIT
// [plant.airpath] of ENGINE.toml: what the simulated air path has beyond the shared [airpath]. Field by field: docs/theory/airpath.md.
#pragma once
#include <optional>

#include "common/toml_file.hpp"

namespace sixdeg::airpath {

/// A position loop: a motor that follows its sensor, with a lag of second order and a limit of speed.
struct ActuatorData {
    double frequency_radps; ///< Natural frequency of the loop.
    double damping;         ///< 1 critical.
    double rate_per_s;      ///< Largest speed, of the full stroke.
};

struct FullData {
    double ambient_pa, ambient_k;

    double cooler_m3, cooler_k, cooler_effectiveness; ///< Charge-air cooler and pipe; its coolant; at no flow, falling with it.
    double cooler_drop_pa;     ///< Pressure lost from there to the intake manifold at 0.1 kg/s, with the square of the flow.
    double intake_m3, exhaust_m3;

    double compressor_m;       ///< Diameter of the wheel.
    double compressor_flow;    ///< Largest flow coefficient W / (rho pi/4 D^2 U).
    double compressor_head;    ///< Head coefficient 2 dh / U^2 at which the flow ends.
    double compressor_efficiency, turbine_efficiency; ///< At best.
    double turbine_closed_m2, turbine_span_m2; ///< Effective area with the vanes closed; what they open.
    double turbine_swallow_drop;               ///< Share of the area lost at turbo_rated, with the square of the speed.
    double turbo_rated_radps, turbo_inertia_kgm2;
    double back_pressure_pa;   ///< Behind the turbine at 0.1 kg/s, with the square of the flow.

    double egr_area_m2;        ///< Effective, valve open.
    double egr_pulsation;      ///< How far the pressure before the valve swings, of its mean.
    double egr_cooler_k, egr_cooler_effectiveness, egr_cooler_s; ///< Coolant; at no flow; lag of its gas.

    double filling, filling_rpm; ///< Volumetric efficiency at equal pressures, at best, and the speed of it.
    double filling_bend;         ///< What is lost at 1000 rpm from there, with the square of the distance.
    double heat_share;           ///< Share of the fuel's heat that leaves with the gas.
    double wall_wpk, wall_jpk;   ///< Of the exhaust manifold: gas to wall; what the wall stores.
    double wall_loss_wpk;        ///< Wall to the surroundings.

    double burn_efficiency;      ///< Brake work of a cylinder plus friction, over the fuel's heat; without a simulated crank.

    ActuatorData egr, vgt;
};

/// None when the file has no [plant.airpath]. Throws InputError.
std::optional<FullData> read_full_data(TomlFile &file);

} // namespace sixdeg::airpath
