// SPDX-License-Identifier: MIT
// TUNE.toml and --set, alike in every command that takes them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "common/toml_file.hpp"

namespace sixdeg {

/// The tune file, or an empty one when `path` is empty, with the assignments made on it. Throws InputError.
inline TomlFile open_tune(const std::string &path, const std::vector<std::string> &assignments) {
    TomlFile tune = path.empty() ? TomlFile("tune", "") : TomlFile(std::filesystem::path(path));
    for (const std::string &assignment : assignments) tune.set(assignment);
    return tune;
}

} // namespace sixdeg
