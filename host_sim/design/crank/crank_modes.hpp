// SPDX-License-Identifier: MIT
// How the crank twists: natural vibrations of the chain front end, throws, flywheel, secondary flywheel, as far as the engine
// file has them. A crank without [torsion] is one rigid link.
#pragma once
#include <vector>

#include "common/engine_file.hpp"

namespace sixdeg {

/// As sd_kalman_mode_t: a mode scaled to the twist of the toothed wheel, in rad.
struct CrankMode {
    double frequency_radps, damping;
    double constant_radpnm;               ///< Twist of the wheel that a torque at the flywheel holds,
    std::vector<double> cylinder_radpnm;  ///< and one at the throw of each entry of firing_order.
    double spring_nmprad, damper_nmprad;  ///< Torque through the dual-mass flywheel, for the twist and its rate over the frequency.
};

/// The lowest elastic ones that move the wheel, ascending, `most` at most.
std::vector<CrankMode> crank_modes(const EngineFile &engine, std::size_t most);

/// All that turns with the crank at low frequency, at crank angle alpha in rad: the secondary mass included.
double turning_inertia_kgm2(const EngineFile &engine, double alpha);

} // namespace sixdeg
