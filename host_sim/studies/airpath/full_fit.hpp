// SPDX-License-Identifier: MIT
// What a test bench would find of the simulated air path: the [airpath] curves of the engine file, from steady points.
#pragma once
#include <string>

#include "plant/scenario/scenario.hpp"

namespace sixdeg {

/// The curves that fit best, as lines of an engine file, and how far single points are from them. `engine` has an air path.
std::string fit_air_path(const PlantEngine &engine);

} // namespace sixdeg
