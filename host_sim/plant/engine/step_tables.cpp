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
    : width(std::size_t(engine.shared.cylinders())), steps(int(std::lround(720 / step_deg))), step_rad(4 * kPi / steps) {
    const int n = engine.shared.cylinders(), count = 2 * steps;
    for (double deg : engine.shared.firing_tdc_deg) tdc_rad.push_back(deg * kRadPerDeg);
    const double constant =
        engine.shared.inertia_kgm2 + (engine.dual_mass ? 0 : engine.driveline_inertia_kgm2);
    inertia.assign(std::size_t(count), constant);
    volume_slope_sum.assign(std::size_t(count), 0.0);
    for (int half = 0; half < count; ++half) {
        for (int lane = 0; lane < n; ++lane) {
            const CrankSlider slider = engine.slider(spread[std::size_t(lane)].compression_ratio);
            const double theta = half * step_rad / 2 - tdc_rad[std::size_t(lane)];
            const double v = slider.volume_m3(theta), slope = slider.volume_slope_m3(theta), warmth = std::pow(v, 1 - kPolytropic);
            volume.push_back(v);
            points.push_back({slope, slope * warmth / v, warmth / v, warmth, step_rad / warmth, slider.wall_area_m2(theta) * std::sqrt(v)});
            volume_slope_sum[std::size_t(half)] += slope;
            inertia[std::size_t(half)] += slider.reciprocating_inertia_kgm2(theta, engine.shared.reciprocating_mass_kg);
        }
    }
    for (double j : inertia) two_over_inertia.push_back(2 / j);
    events = events_of(engine, *this);
}

} // namespace sixdeg
