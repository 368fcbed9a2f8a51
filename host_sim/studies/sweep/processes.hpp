// SPDX-License-Identifier: MIT
// Many runs of a program side by side.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace sixdeg {

/// How one command ended.
struct Ended {
    std::size_t index;  ///< Into the commands.
    int status;         ///< Exit status; 128 + signal when a signal ended it.
    std::string errors; ///< What it wrote to stderr, at most 64 KiB.
};

/// Runs each command (program, then arguments) with its stdout thrown away, `jobs` at a time, in order; tells `ended`
/// of each. When that returns false, or a signal asks to stop (common/stop.hpp), nothing new is started. Throws
/// std::system_error when a process cannot be started.
void run_all(const std::vector<std::vector<std::string>> &commands, std::size_t jobs,
             const std::function<bool(const Ended &)> &ended);

} // namespace sixdeg
