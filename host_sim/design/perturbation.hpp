// SPDX-License-Identifier: MIT
// A calibration that is as wrong as real ones are: what the firmware believes of the engine, moved a little.
#pragma once
#include <cstdint>
#include <vector>

#include "common/engine_file.hpp"

namespace sixdeg {

/// Largest errors; each is drawn evenly from within +- its value.
struct PerturbationRanges {
    double inertia_percent = 3, reciprocating_percent = 5, compression_percent = 2, trapped_mass_percent = 3,
           wheel_offset_deg = 0.3, exhaust_flow_percent = 5, uego_tau_percent = 20, uego_delay_deg = 10;
};

/// What was drawn: belief over truth, in percent and degrees (of the sensor's delay: at 1500 rpm).
struct Perturbation {
    double inertia_percent, reciprocating_percent, wheel_offset_deg;
    std::vector<double> compression_percent, trapped_mass_percent; ///< By entry of firing_order.
    double exhaust_flow_percent, uego_tau_percent, uego_delay_deg;
};

/// The same seed draws the same errors.
Perturbation draw_perturbation(const EngineFile &engine, std::uint64_t seed, const PerturbationRanges &ranges = {});
/// The engine as the firmware is told, its tolerance included.
EngineFile perturbed(const EngineFile &engine, const Perturbation &perturbation, const PerturbationRanges &ranges = {});

} // namespace sixdeg
