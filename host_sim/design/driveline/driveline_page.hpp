// SPDX-License-Identifier: MIT
// The driveline in the calibration page, from the engine file's [driveline].
#pragma once
#include <string>

#include "design/calibration.hpp"

namespace sixdeg {

/// Puts it behind the used words of the page's pool; without a [driveline] nothing changes. The filter on tooth times must be in the page
/// already. Throws InputError naming the engine file when it is not, or when there is no room.
void add_driveline(const EngineFile &engine, sd_calibration_t &page);

} // namespace sixdeg
