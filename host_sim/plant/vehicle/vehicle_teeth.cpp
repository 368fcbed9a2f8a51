// SPDX-License-Identifier: MIT
#include "plant/vehicle/vehicle_teeth.hpp"

#include "plant/engine/units.hpp"

namespace sixdeg {

void VehicleTeeth::pass(const Point &from, const Point &to, std::vector<ToothEdge> &edges) {
    const double pitch = 2 * kPi / wheel_.positions, turned = to.angle_rad - from.angle_rad;
    if (turned <= 0 || from.speed_radps <= 0 || to.speed_radps <= 0) return;
    for (; double(next_) * pitch <= to.angle_rad; ++next_, ++advance_) {
        const int position = int(next_ % wheel_.positions);
        if (position >= wheel_.positions - wheel_.missing) continue;
        const double x = (double(next_) * pitch - from.angle_rad) / turned, y = 1 - x;
        const double rise0 = turned / from.speed_radps, rise1 = turned / to.speed_radps;
        const double time = from.time_s * y * y * (1 + 2 * x) + to.time_s * x * x * (1 + 2 * y) + x * y * (rise0 * y - rise1 * x);
        const double shift = wheel_.jitter_rad * noise_.normal() + (wheel_.pattern_rad.empty() ? 0
                                                                    : wheel_.pattern_rad[std::size_t(position)]);
        edges.push_back({time + shift / (from.speed_radps * y + to.speed_radps * x), position, advance_});
        advance_ = 0;
    }
}

} // namespace sixdeg
