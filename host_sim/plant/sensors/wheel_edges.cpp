// SPDX-License-Identifier: MIT
#include "plant/sensors/wheel_edges.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

std::vector<double> draw_pattern(int teeth, double rms_deg, RandomStream &random) {
    std::vector<double> pattern(std::size_t(teeth), 0.0);
    if (rms_deg <= 0) return pattern;
    double mean = 0, square = 0;
    for (double &p : pattern) mean += (p = random.normal()) / teeth;
    for (double &p : pattern) p -= mean, square += p * p / teeth;
    for (double &p : pattern) p *= rms_deg / std::sqrt(square);
    return pattern;
}

} // namespace

WheelEdges::WheelEdges(const EngineFile &engine, double offset_deg, double pattern_rms_deg,
                       double tooth_width_deg, RandomStream random)
    : tooth_width_deg_(tooth_width_deg) {
    const Wheel &wheel = engine.wheel;
    const auto pattern = draw_pattern(wheel.teeth(), pattern_rms_deg, random);
    for (int position = 0; position < wheel.positions; ++position) {
        if (std::find(wheel.missing.begin(), wheel.missing.end(), position) != wheel.missing.end()) continue;
        const double nominal = engine.position_0_deg + offset_deg + position * 360.0 / wheel.positions;
        const double error = pattern[teeth_.size()];
        teeth_.push_back({nominal - 360 * std::floor(nominal / 360) + error, error, position});
    }
    std::sort(teeth_.begin(), teeth_.end(),
              [](const Tooth &a, const Tooth &b) { return a.angle_deg < b.angle_deg; });
    seek(0);
}

WheelEdge WheelEdges::edge(std::int64_t index) const {
    const auto count = std::int64_t(teeth_.size());
    const std::int64_t turn = index >= 0 ? index / count : -((count - 1 - index) / count);
    const Tooth &tooth = teeth_[std::size_t(index - turn * count)];
    return {tooth.angle_deg + 360.0 * double(turn), tooth.position};
}

void WheelEdges::refresh() {
    forward_ = edge(up_);
    backward_ = edge(down_);
    backward_.angle_deg -= tooth_width_deg_;
}

void WheelEdges::seek(double angle_deg) {
    const auto count = std::int64_t(teeth_.size());
    const std::int64_t near = std::int64_t(std::floor(angle_deg / 360)) * count;
    up_ = near - 1;
    while (edge(up_).angle_deg <= angle_deg) ++up_;
    down_ = near + count + 1;
    while (edge(down_).angle_deg - tooth_width_deg_ >= angle_deg) --down_;
    refresh();
}

std::vector<double> WheelEdges::pattern_deg(int positions) const {
    std::vector<double> pattern(std::size_t(positions), 0.0);
    for (const Tooth &tooth : teeth_) pattern[std::size_t(tooth.position)] = tooth.pattern_deg;
    return pattern;
}

} // namespace sixdeg
