// SPDX-License-Identifier: MIT
// What the air path's sensors say, as samples for an ecu.
#pragma once
#include "io/events/ecu_feed.hpp"
#include "plant/airpath/air_path.hpp"

namespace sixdeg {

/// Every reading of one time as the input that the signal table has for it, in its unit. A silent sensor sends nothing.
void send_readings(EcuFeed &ecu, const airpath::Readings &readings);

} // namespace sixdeg
