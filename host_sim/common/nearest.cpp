// SPDX-License-Identifier: MIT
#include "common/nearest.hpp"

#include <algorithm>

#include "renamed_parameters.hpp"

namespace fs = std::filesystem;
namespace sixdeg {

int edit_distance(const std::string &a, const std::string &b) {
    std::vector<std::vector<int>> steps(a.size() + 1, std::vector<int>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                steps[i][j] = int(i + j);
                continue;
            }
            steps[i][j] = std::min({steps[i - 1][j] + 1, steps[i][j - 1] + 1, steps[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) steps[i][j] = std::min(steps[i][j], steps[i - 2][j - 2] + 1);
        }
    }
    return steps[a.size()][b.size()];
}

namespace {

/// How much of both is the name of the same table, the dot at its end included.
std::size_t same_table(const std::string &a, const std::string &b) {
    std::size_t shared = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i) {
        if (a[i] == '.') shared = i + 1;
    }
    return shared;
}

} // namespace

std::string nearest_hint(const std::string &word, const std::vector<std::string> &names) {
    for (const Renamed &parameter : renamed_parameters) {
        if (word == parameter.before) return std::string("; it is called '") + parameter.now + "' now";
    }
    const std::string *nearest = nullptr;
    int least = int(word.size());
    for (const std::string &name : names) {
        if (name == word) continue;
        const std::size_t shared = same_table(word, name);
        const std::string part = word.substr(shared);
        const int distance = edit_distance(part, name.substr(shared));
        if (distance <= int(part.size()) / 3 && distance < least) least = distance, nearest = &name;
    }
    return nearest ? "; the nearest is '" + *nearest + "'" : "";
}

std::string nearest_file_hint(const fs::path &path) {
    std::error_code ec;
    if (fs::exists(path, ec)) return "";
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    std::vector<std::string> names;
    for (const auto &entry : fs::directory_iterator(folder, ec)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return nearest_hint(path.filename().string(), names);
}

} // namespace sixdeg
