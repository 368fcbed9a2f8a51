// SPDX-License-Identifier: MIT
// What the firmware is told about one firing: torque of a single cylinder over the cycle, by a model of its own.
//
// Single zone of air, p in Pa, angle a from firing TDC:
//   closed:  dp/da = ((gamma - 1) (Q' - Qw') - gamma p V') / V
//   open:    p goes to the manifold's pressure at a fixed rate
// once with heat and once without; torque is (p - p_crankcase) V'. gamma from the vibration of N2 and O2 (Einstein's
// function), wall loss after Hohenberg (SAE 790825). docs/theory/torque.md says how far that is from the simulated engine.
#pragma once
#include <functional>
#include <vector>

#include "common/engine_file.hpp"

namespace sixdeg {

/// Torque of one cylinder over its cycle, at `kPulsePoints` equal steps from its firing TDC.
struct CylinderPulse {
    std::vector<double> combustion;      ///< Fired less motored; its mean over the 180 deg after TDC is 1.
    std::vector<double> motored_per_bar; ///< N m for each bar of intake pressure, without combustion.
    std::vector<double> motored_rest;    ///< N m beside it: crankcase and exhaust pressure.
};

constexpr int kPulsePoints = 1440; ///< 0.5 deg apart.

/// Conditions the pulse is computed for; a usual load by default. Shape hardly depends on them.
struct PulseConditions {
    double intake_bar = 1.2;
    double speed_radps = 200;       ///< For the wall loss.
    double equivalence_ratio = 0.5; ///< Heat over what the trapped air could burn.
    double wall_factor = 1;         ///< On the wall loss.
    double charge_k = 340;          ///< When the intake valve closes.
    double exhaust_bar = 1.1;       ///< Behind the open exhaust valve.
    double exponent = 0;            ///< Added to gamma.
};

/// Entry `lane` of firing_order, with the engine file's belief about its compression.
CylinderPulse cylinder_pulse(const EngineFile &engine, std::size_t lane, const PulseConditions &conditions = {});

/// What twice the wall loss adds to `combustion`, whose mean stays 1.
std::vector<double> pulse_bend(const EngineFile &engine, std::size_t lane, const CylinderPulse &pulse);

/// What a gamma that is larger by 1 would add to `motored_per_bar`, from small changes.
std::vector<double> motored_over_exponent(const EngineFile &engine, std::size_t lane);

/// The first entry of firing_order under several conditions; cheaper than one by one.
std::vector<CylinderPulse> cylinder_pulses(const EngineFile &engine, const std::vector<PulseConditions> &conditions);

/// First entry of firing_order whose pulse is that of `lane` too: they differ by compression alone.
std::size_t like_cylinder(const EngineFile &engine, std::size_t lane);

/// Pressure in the first cylinder when its exhaust valve opens, Pa, for any conditions. The engine must outlive it.
std::function<double(const PulseConditions &)> exhaust_opening(const EngineFile &engine);

/// Value of one of the tables at any angle from the cylinder's firing TDC, rad; linear between points.
double pulse_at(const std::vector<double> &table, double angle_rad);

} // namespace sixdeg
