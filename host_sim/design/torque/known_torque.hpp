// SPDX-License-Identifier: MIT
// What the filter on tooth times is told of an engine: the pulses of its cylinders (pulse.hpp) over crank angle.
#pragma once
#include <optional>

#include "design/torque/kalman_tables.hpp"
extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {

/// Nothing when the engine file tells no heat release.
std::optional<KnownTorque> known_torque(const EngineFile &engine, const sd_parameters_t &parameters);

/// cos and sin of harmonics 1 to n of the cycle: the Fourier basis.
std::vector<TorqueOverAngle> fourier_basis(int harmonics);

/// The filter's part of the parameters.
KalmanTune kalman_tune(const EngineFile &engine, const sd_parameters_t &parameters);

} // namespace sixdeg
