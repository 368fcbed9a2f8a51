// SPDX-License-Identifier: MIT
// Whether document 004's AFR chain converges with the gains of a page: its error over one cycle.
#pragma once
extern "C" {
#include "sd_calibration.h"
}

namespace sixdeg {

/// Largest eigenvalue, by magnitude, of the error of the chain that the page chooses (afr.method) over one cycle: below 1 it
/// converges. The worst over the grid's speeds, the middles between them, its pressures and mixtures; read off the firmware's
/// own steps, which are linear in their state. 0 where the page chooses the joint filter or has no exhaust.
double chain_radius(const sd_calibration_t &page);

} // namespace sixdeg
