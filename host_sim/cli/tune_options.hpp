// SPDX-License-Identifier: MIT
// TUNE.toml and --set, alike in every command that takes them.
#pragma once
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/toml_file.hpp"
extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {

/// The tune file, or an empty one when `path` is empty, with the assignments made on it; `number` is --number: f32, q31
/// or empty. Throws InputError.
inline TomlFile open_tune(const std::string &path, const std::vector<std::string> &assignments,
                          const std::string &number = "") {
    TomlFile tune = path.empty() ? TomlFile("tune", "") : TomlFile(std::filesystem::path(path));
    for (const std::string &assignment : assignments) tune.set(assignment);
    if (!number.empty()) tune.set(std::string("torque.fixed_point=") + (number == "q31" ? "1" : "0"));
    return tune;
}

/// Every parameter by its name, for summaries.
inline nlohmann::ordered_json parameters_json(const sd_parameters_t &parameters) {
    nlohmann::ordered_json json;
    const float *value = reinterpret_cast<const float *>(&parameters);
    for (const sd_signal_info_t &info : sd_parameter_infos) {
        // Through text, so that 0.05f reads 0.05.
        json[info.name] = std::stod(fmt::format("{:.7g}", *value++));
    }
    return json;
}

} // namespace sixdeg
