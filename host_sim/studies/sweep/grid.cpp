// SPDX-License-Identifier: MIT
#include "studies/sweep/grid.hpp"

#include <algorithm>

#include "common/error.hpp"

namespace sixdeg {

Axis parse_axis(const std::string &text) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        throw InputError("--over", "'" + text + "'", "is not field=value,value,...");
    Axis axis{text.substr(0, equals), {""}};
    int depth = 0;
    bool quoted = false;
    for (char c : text.substr(equals + 1)) {
        if (c == '"') quoted = !quoted;
        if (!quoted) depth += (c == '[') - (c == ']');
        if (c == ',' && depth == 0 && !quoted)
            axis.values.emplace_back();
        else
            axis.values.back() += c;
    }
    auto sorted = axis.values;
    std::sort(sorted.begin(), sorted.end());
    if (sorted.front().empty()) throw InputError("--over", axis.field, "has an empty value");
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) throw InputError("--over", axis.field, "has " + *twice + " twice");
    return axis;
}

std::vector<std::vector<std::string>> cells_of(const std::vector<Axis> &axes) {
    std::vector<std::vector<std::string>> cells{{}};
    for (const Axis &axis : axes) {
        std::vector<std::vector<std::string>> longer;
        for (const auto &cell : cells) {
            for (const std::string &value : axis.values) {
                longer.push_back(cell);
                longer.back().push_back(axis.field + "=" + value);
            }
        }
        cells = std::move(longer);
    }
    return cells;
}

} // namespace sixdeg
