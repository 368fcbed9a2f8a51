// SPDX-License-Identifier: MIT
// The observers of document 001 on the full air path: delays, false alarms, transients, other faults (docs/results/airpath.md).
#pragma once
#include "studies/airpath/full_cases.hpp"

namespace sixdeg {

struct FullStudy {
    const PlantEngine &engine;
    sd_airpath_tables_f32_t tables;
    sd_airpath_config_f32_t config;
    int runs = 500; ///< Of each fault whose delay is measured; others get a fifth of it. Below 50 all is shorter.
    std::uint64_t seed = 1;
};

/// Prints all tables.
void print_full_study(const FullStudy &study);

} // namespace sixdeg
