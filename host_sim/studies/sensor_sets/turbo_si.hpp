// SPDX-License-Identifier: MIT
// A mean-value turbocharged SI engine with the 13 states of document 002: pressure and temperature of air
// filter, compressor outlet, intercooler, intake manifold, exhaust manifold and turbine outlet, and
// turbocharger speed. Volumes are open, adiabatic, of ideal gas; between them stand restrictions that store
// nothing. Parameters: the published VEP engine of the fault diagnosis toolbox
// (faultdiagnosistoolbox/pyfaultdiagnosistoolbox, Engine/VEP_par.py); what we left out is listed in
// docs/theory/sensors.md.
#pragma once
#include <array>

#include "studies/sensor_sets/linear_point.hpp"

namespace sixdeg {

struct TurboSiInputs {
    double speed_radps = 200; ///< Engine speed, [50, 850].
    double throttle_rad = 0.5;
    double wastegate = 0; ///< Opening, [0, 1].
    double lambda = 1;
    double ambient_pa = 101300, ambient_k = 293;
};

constexpr int turbo_si_states = 13, turbo_si_sensors = 17;
using TurboSiState = std::array<double, turbo_si_states>;

/// Rate of every state, SI. Order: paf Taf pcomp Tcomp pic Tic pim Tim pem Tem pt Tt wtc.
TurboSiState turbo_si_rates(const TurboSiState &state, const TurboSiInputs &inputs);

/// The steady state at these inputs and the Jacobians there, exact by automatic differentiation. The regime
/// is "choked" or "unchoked", as the throttle is. Throws InputError when there is no steady state.
LinearPoint turbo_si_point(const TurboSiInputs &inputs);

/// True when the model's states, sensors and regimes are those of this engine, in its order.
bool turbo_si_fits(const SensorModel &model);

} // namespace sixdeg
