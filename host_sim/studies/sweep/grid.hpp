// SPDX-License-Identifier: MIT
// A grid over scenario fields: which cells it has, and what each of them is called.
#pragma once
#include <string>
#include <vector>

namespace sixdeg {

/// One field and the values it takes, as TOML text.
struct Axis {
    std::string field;
    std::vector<std::string> values;
};

/// "speed.rpm=1000,2000" -> {"speed.rpm", {"1000", "2000"}}. Commas within brackets or quotes belong to a value. Throws
/// InputError naming --over.
Axis parse_axis(const std::string &text);

/// All combinations, the last axis running fastest; each cell one "field=value" for each axis.
std::vector<std::vector<std::string>> cells_of(const std::vector<Axis> &axes);

} // namespace sixdeg
