// SPDX-License-Identifier: MIT
// The whole firmware's mixture of each cylinder where it was not born: on exhausts that share nothing with the calibration's but their
// drawing, and at rest.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "plant/engine/plant_engine.hpp"

namespace sixdeg {

/// Another gas (gamma 1.30 to 1.38), wall loss of the cylinders 0 to 2 times, other pulses, no loss in the manifold's walls, no pressure
/// behind the turbine, and one turbine area in place of vanes, which the calibration knows, and no reading of a test bench. Drawn from the
/// seed; rpm: at which the area is some 0.85 to 1.2 of the vanes'.
void make_other_exhaust(PlantEngine &engine, double rpm, std::uint64_t seed);
/// After a step of an injector, own exhaust and others.
void print_other_exhausts(int seeds, const std::vector<std::string> &tune);
/// Figure 16's course of document 004 until 35 s: trims rest since 7.5 s, cylinder 2's injector moved at 19 s.
void print_at_rest(int seeds, const std::vector<std::string> &tune);

} // namespace sixdeg
