// SPDX-License-Identifier: MIT
// What a caller of the guess knows, in one word each.
#pragma once
#include "io/recording/guess.hpp"

inline sixdeg::Constraints with_wheel(const char *wheel, std::optional<sixdeg::Edge> edge = {}, std::optional<int> column = {}) {
    sixdeg::Constraints known;
    known.wheel = sixdeg::parse_wheel_text(wheel, "test");
    known.edge = edge, known.column = column;
    return known;
}

inline sixdeg::Constraints with_edge(sixdeg::Edge edge) {
    sixdeg::Constraints known;
    known.edge = edge;
    return known;
}

inline sixdeg::Constraints with_column(int column) {
    sixdeg::Constraints known;
    known.column = column;
    return known;
}
