// SPDX-License-Identifier: MIT
// Constant gains of the oscillator form of the sensor's inversion (firmware/afr/sd_uego.h).
#pragma once
extern "C" {
#include "sd_uego.h"
}

namespace sixdeg {

struct UegoDesign {
    double tau1_s, tau2_s, step_s;
    int cycle_positions, harmonics;
    double noise, drift; ///< Of lambda: rms a position; random walk of each coefficient in a cycle.
};

/// From the Riccati equation of the averaged problem. In coordinates that turn with each harmonic, it has a steady state.
sd_uego_gains_t uego_gains(const UegoDesign &design);

} // namespace sixdeg
