// SPDX-License-Identifier: MIT
#include "identify/compression.hpp"

#include <cmath>

#include "design/crank/slider_crank.hpp"

namespace sixdeg {
namespace {

constexpr double kAfterClosingDeg = 10, kUntilDeg = -40;

/// Sums of a straight line through points.
struct Line {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    void add(double px, double py) { n += 1, x += px, y += py, xx += px * px, xy += px * py; }
    double slope() const { return (n * xy - x * y) / (n * xx - x * x); }
    double at_zero() const { return (y - slope() * x) / n; }
};

/// Calls `take(volume, index)` for each point of the compression.
template <typename Take> void each(const EngineFile &engine, double offset_rad, double factor, const Take &take) {
    const SliderCrank crank(engine, factor);
    for (int i = 0; i < kGridPoints; ++i) {
        const double deg = grid_deg(i) + offset_rad * 180 / M_PI;
        if (deg > engine.intake_close_deg - 720 + kAfterClosingDeg && deg < kUntilDeg) take(crank.volume(deg * M_PI / 180), i);
    }
}

} // namespace

double compression_level_bar(const EngineFile &engine, const Eigen::VectorXd &recorded, double offset_rad) {
    Line line;
    const double bottom = SliderCrank(engine).volume(M_PI);
    each(engine, offset_rad, 1, [&](double volume, int i) { line.add(std::pow(volume / bottom, -kUsualExponent), recorded(i)); });
    return -line.at_zero();
}

double compression_exponent(const EngineFile &engine, const Eigen::VectorXd &bar, double offset_rad, double compression_factor) {
    Line line;
    each(engine, offset_rad, compression_factor, [&](double volume, int i) { line.add(std::log(volume), std::log(bar(i))); });
    return -line.slope();
}

} // namespace sixdeg
