// SPDX-License-Identifier: MIT
// One kind of failure the user can mend: bad input. main() prints it as one line and exits with status 2.
#pragma once
#include <stdexcept>
#include <string>

namespace sixdeg {

/// A file, field or option that cannot be used. what() is one line: "FILE: FIELD: what is wrong and what is allowed".
/// Pass an empty field when the file as a whole is at fault.
struct InputError : std::runtime_error {
    InputError(const std::string &file, const std::string &field, const std::string &problem)
        : std::runtime_error(file + ": " + (field.empty() ? "" : field + ": ") + problem) {}
};

/// What was asked for ran, and its files are written, but the recording could not be followed. what() is one line; exit status 3.
struct NotFollowed : std::runtime_error {
    NotFollowed(const std::string &file, const std::string &reason) : std::runtime_error(file + ": " + reason) {}
};

} // namespace sixdeg
