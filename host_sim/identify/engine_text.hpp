// SPDX-License-Identifier: MIT
// An engine file with some of its numbers measured: the text of the first file, with new values in place and a comment behind each number
// that says where it is from.
#pragma once
#include <map>
#include <string>

namespace sixdeg {

/// A value that goes into the file, in TOML syntax, and what the comment says of it.
struct NewValue {
    std::string text, comment;
};

/// `text`, the content of `name`, with each field of `values` (dotted path) replaced or, where it is missing, added to its table; every
/// other number gets the comment that it is taken from `name`, ahead of the comment that it has. Lines, order and other comments stay.
/// Throws InputError where a field cannot be put in.
std::string engine_with(const std::string &name, const std::string &text, const std::map<std::string, NewValue> &values);

} // namespace sixdeg
