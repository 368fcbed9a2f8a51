// SPDX-License-Identifier: MIT
// What the words of a recording's header mean.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace sixdeg {

/// ASCII letters made small.
std::string lower(std::string_view text);
/// "Time [s]", "timestamp", "Zeit" and their like, whatever unit follows.
bool is_time_name(const std::string &name);
/// "ToothTime", "dt", "period" and their like: the time since the row above.
bool is_interval_name(const std::string &name);
/// "tick", "sample" and their like: a count that is no time by itself.
bool is_count_name(const std::string &name);
/// Whether a line of the header holds units: "s", "(V)", "[ms]".
bool looks_like_units(const std::vector<std::string> &cells);
/// 1, 1e-3, 1e-6 or 1e-9 for "s", "[ms]", "Time (us)" and their like; 0 where the text names no unit of time.
double time_unit_of(std::string_view text);

} // namespace sixdeg
