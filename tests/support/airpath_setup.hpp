// SPDX-License-Identifier: MIT
// Document 001's engine of the matched plant with its design, read once a test program.
#pragma once
#include <string>

#include "studies/airpath/matched_run.hpp"

namespace sixdeg::test {

const std::string kAirPath = SD_MODELS "/airpath_matched.toml", kDesign = SD_MODELS "/airpath_matched_design.toml";

inline const MatchedSetup &setup() {
    static const MatchedSetup read = read_matched_setup(kAirPath, kDesign);
    return read;
}

} // namespace sixdeg::test
