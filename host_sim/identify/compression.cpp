// SPDX-License-Identifier: MIT
#include "identify/compression.hpp"

#include <cmath>
#include <utility>

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

struct Window {
    double from_deg, to_deg;
};
constexpr Window kWindows[] = {{-110, -25}, {-100, -30}, {-90, -25}, {-120, -40}};
constexpr double kFarthestDeg = 15, kTryDeg = 0.5;

/// The straight line that a compression is: of ln p over ln V where the level is known, its slope free; else of p over (V/V_bottom)^-n, its
/// zero free.
struct LineOf {
    bool absolute;
    double exponent;
    double x(double volume) const { return absolute ? std::log(volume) : std::pow(volume, -exponent); }
    double y(double bar) const { return absolute ? std::log(std::fmax(bar, 1e-3)) : bar; }
};

/// Sum over cycles of the squares that the line leaves.
double left_of_line(const EngineFile &engine, const std::vector<Eigen::VectorXd> &bar, Window window, LineOf of, double offset_deg) {
    const SliderCrank crank(engine);
    const double bottom = crank.volume(M_PI), opens = engine.intake_close_deg - 720 + kAfterClosingDeg;
    std::vector<std::pair<int, double>> points;
    for (int i = 0; i < kGridPoints; ++i) {
        const double deg = grid_deg(i) + offset_deg;
        if (deg > std::fmax(window.from_deg, opens) && deg < window.to_deg)
            points.emplace_back(i, of.x(crank.volume(deg * M_PI / 180) / bottom));
    }
    double sum = 0;
    for (const Eigen::VectorXd &cycle : bar) {
        Line line;
        double squares = 0;
        for (const auto &[i, x] : points) {
            const double y = of.y(cycle(i));
            line.add(x, y), squares += y * y;
        }
        sum += squares - line.at_zero() * line.y - line.slope() * line.xy;
    }
    return sum / double(points.size());
}

/// deg; NaN where it is not within what is tried.
double best_offset(const EngineFile &engine, const std::vector<Eigen::VectorXd> &bar, Window window, LineOf of) {
    const auto left = [&](double deg) { return left_of_line(engine, bar, window, of, deg); };
    double best = -kFarthestDeg, least = left(best);
    for (double at = best + kTryDeg; at <= kFarthestDeg; at += kTryDeg)
        if (const double here = left(at); here < least) least = here, best = at;
    if (std::abs(best) > kFarthestDeg - kTryDeg / 2) return std::nan("");
    const double before = left(best - kTryDeg), after = left(best + kTryDeg);
    return best + kTryDeg / 2 * (before - after) / (before - 2 * least + after);
}

} // namespace

CompressionTdc compression_tdc(const EngineFile &engine, const std::vector<Eigen::VectorXd> &bar, double level_sd_bar) {
    const bool absolute = std::isfinite(level_sd_bar);
    const auto at = [&](Window window, double by) {
        if (!absolute) return best_offset(engine, bar, window, {false, kUsualExponent + by * kUsualExponentSd});
        std::vector<Eigen::VectorXd> moved = bar;
        for (Eigen::VectorXd &cycle : moved) cycle.array() += by * level_sd_bar;
        return best_offset(engine, moved, window, {true, 0});
    };
    double sum = 0, squares = 0, by_guess = 0, count = 0;
    for (const Window &window : kWindows) {
        const double own = at(window, 0);
        sum += own, squares += own * own, count += 1;
        by_guess += std::abs(at(window, 1) - at(window, -1)) / 2;
    }
    const double mean = sum / count, scatter = (squares - sum * mean) / (count - 1);
    return {mean * M_PI / 180, std::sqrt(std::pow(by_guess / count, 2) + std::fmax(scatter, 0)) * M_PI / 180};
}

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
