// SPDX-License-Identifier: MIT
// The valid name that a misspelt one was probably meant to be, for messages.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace sixdeg {

/// Letters to insert, remove, change or swap with their neighbour until `a` is `b` (Damerau-Levenshtein, no letter touched twice).
int edit_distance(const std::string &a, const std::string &b);

/// "; the nearest is 'NAME'" for the name that differs from `word` least, or nothing where none is near: at most one letter in three
/// differs, a table that both begin with ("misfire.") not counted. Of several equally near the first.
/// A parameter's name of before: "; it is called 'NAME' now".
std::string nearest_hint(const std::string &word, const std::vector<std::string> &names);

/// The same among the files of the folder that `path` names.
std::string nearest_file_hint(const std::filesystem::path &path);

} // namespace sixdeg
