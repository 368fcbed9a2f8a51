// SPDX-License-Identifier: MIT
// --out of every command that writes a folder.
#pragma once
#include <CLI/App.hpp>
#include <string>

namespace sixdeg {

/// Adds --out FOLDER. "-" is refused before anything runs: standard output holds one file.
inline CLI::Option *add_output_folder(CLI::App *command, std::string &folder, const std::string &what) {
    return command->add_option("--out", folder, what)->check([](const std::string &path) {
        return std::string(path == "-" ? "standard output holds one file; give a folder" : "");
    });
}

} // namespace sixdeg
