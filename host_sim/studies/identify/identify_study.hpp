// SPDX-License-Identifier: MIT
// How `sixdeg identify` does on engines drawn by seed: do its intervals hold the truth, and how wide are they.
#pragma once
#include <cstdint>

namespace sixdeg {

struct IdentifyStudy {
    int engines = 200;
    std::uint64_t seed = 1001;  ///< Of the first engine; the next ones follow.
    bool each = false;          ///< A line an engine beside the table.
};

void print_identify_study(const IdentifyStudy &study);

} // namespace sixdeg
