// SPDX-License-Identifier: MIT
// Where behind each firing the crank's energy is read for the work of a cycle (firmware/torque/sd_work.h).
#pragma once
#include "common/engine_file.hpp"
extern "C" {
#include "sd_work.h"
}

namespace sixdeg {

/// Windows between teeth that are there. Their length at most: `longest_deg`; 0: from the firing's exhaust, no earlier than BDC, to the
/// next compression where these are at least 60 deg apart, else 60 deg, from 45 deg ahead of the next firing TDC to 15 deg behind it.
/// Windows do not overlap. None where the crank is not one mass (dual-mass flywheel), and where the wheel's teeth are too wide apart.
sd_work_tables_t work_windows(const EngineFile &engine, double longest_deg);

/// Share of a firing's own work in the difference of its window and the one before it, 0 to 1; one for each entry of firing_order.
std::vector<double> own_shares(const EngineFile &engine, const sd_work_tables_t &tables);

} // namespace sixdeg
