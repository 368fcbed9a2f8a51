// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "plant/engine/engine_model.hpp"

namespace sixdeg {
namespace {

int nearest_step(double angle_rad, const StepTables &tables) {
    const long step = std::lround(angle_rad / tables.step_rad) % tables.steps;
    return int(step < 0 ? step + tables.steps : step);
}

std::vector<Event> events_of(const PlantEngine &engine, const StepTables &tables) {
    std::vector<Event> events;
    for (int lane = 0; lane < int(tables.tdc_rad.size()); ++lane) {
        const double tdc = tables.tdc_rad[std::size_t(lane)];
        const auto add = [&](double after_tdc, EventKind kind) {
            events.push_back({nearest_step(tdc + after_tdc, tables), lane, kind});
        };
        add(engine.intake_close_rad, EventKind::intake_close);
        add(0, EventKind::tdc);
        add(kPi, EventKind::half_turn);
        add(engine.exhaust_open_rad, EventKind::exhaust_open);
        add(2 * kPi, EventKind::exchange);
    }
    std::stable_sort(events.begin(), events.end(),
                     [](const Event &a, const Event &b) { return a.step < b.step; });
    return events;
}

} // namespace

StepTables::StepTables(const PlantEngine &engine, const std::vector<CylinderSpread> &spread, double step_deg)
    : steps(int(std::lround(720 / step_deg))), step_rad(4 * kPi / steps),
      width(engine.shared.cylinders()) {
    const int n = engine.shared.cylinders(), points = 2 * steps;
    for (double deg : engine.shared.firing_tdc_deg) tdc_rad.push_back(deg * kRadPerDeg);
    const double constant =
        engine.shared.inertia_kgm2 + (engine.dual_mass ? 0 : engine.driveline_inertia_kgm2);
    inertia.assign(std::size_t(points), constant);
    volume.assign(std::size_t(points * width), 1.0);
    volume_slope.assign(volume.size(), 0.0);
    wall.assign(volume.size(), 0.0);
    volume_slope_sum.assign(std::size_t(points), 0.0);
    for (int point = 0; point < points; ++point) {
        for (int lane = 0; lane < n; ++lane) {
            const CrankSlider slider = engine.slider(spread[std::size_t(lane)].compression_ratio);
            const double theta = point * step_rad / 2 - tdc_rad[std::size_t(lane)];
            const auto at = std::size_t(point * width + lane);
            volume[at] = slider.volume_m3(theta);
            volume_slope[at] = slider.volume_slope_m3(theta);
            volume_slope_sum[std::size_t(point)] += volume_slope[at];
            wall[at] = slider.wall_area_m2(theta) * std::sqrt(volume[at]);
            inertia[std::size_t(point)] +=
                slider.reciprocating_inertia_kgm2(theta, engine.shared.reciprocating_mass_kg);
        }
    }
    for (double j : inertia) two_over_inertia.push_back(2 / j);
    events = events_of(engine, *this);
}

} // namespace sixdeg
