// SPDX-License-Identifier: MIT
#include "loop/phase_finder.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

// Behind a firing TDC the crank is fastest some 90 deg later; at it, it is slowest.
constexpr double kTopDeg = 30, kFromDeg = 60, kToDeg = 120;
constexpr long kRevolutionsMax = 400;
// From chance alone six deviations do not come, nor nine cycles of ten on one side.
constexpr double kClearSds = 6, kClearShare = 0.9;
constexpr std::size_t kLeastCycles = 6;

double squared_speed(const sd_signals_t &signals) { return std::pow(double(signals.crank_speed_rpm) * M_PI / 30, 2); }

bool is_tooth(const sd_signals_t &signals) { return int(signals.crank_edge_class) == SD_EDGE_TOOTH && signals.crank_speed_rpm > 0; }

} // namespace

void PhaseFinder::tooth(std::size_t, const ToothRow &row) {
    if (ended_) return;
    if (int(row.signals.crank_edge_class) == SD_EDGE_UNSYNCED) {
        ended_ = revolution_ >= 0;
        return;
    }
    if (!is_placed(row.signals)) return;
    const int tooth = int(row.signals.crank_tooth), positions = engine_.wheel.positions;
    if (tooth >= positions) return;
    if (tooth < last_tooth_ || revolution_ < 0) ++revolution_;
    last_tooth_ = tooth;
    ended_ = revolution_ >= kRevolutionsMax;
    squared_.resize(std::size_t((revolution_ + 1) * positions), 0);
    if (is_tooth(row.signals)) squared_[std::size_t(revolution_ * positions + tooth)] = squared_speed(row.signals);
}

/// Over the teeth within a stretch, in positions; NaN without one.
double PhaseFinder::mean_squared(double from, double to) const {
    double sum = 0;
    int count = 0;
    for (long at = std::max(0L, long(std::ceil(from))); at <= long(to) && at < long(squared_.size()); ++at)
        if (squared_[std::size_t(at)] > 0) sum += squared_[std::size_t(at)], ++count;
    return count > 0 ? sum / count : std::nan("");
}

PhaseFinder::Answer PhaseFinder::answer() const {
    Answer answer;
    const std::vector<double> &tdc = engine_.firing_tdc_deg;
    const auto has = [&](double deg) {
        return std::any_of(tdc.begin(), tdc.end(), [&](double other) { return std::abs(std::remainder(other - deg, 720)) < 1; });
    };
    answer.fires_alike = std::all_of(tdc.begin(), tdc.end(), [&](double deg) { return has(deg + 360); });
    if (answer.fires_alike) return answer;
    const double turn = engine_.wheel.positions, pitch_deg = 360 / turn;
    const auto speeding_up = [&](double deg) { // of the square of the speed behind an angle, from the first revolution on
        const double at = (deg - engine_.position_0_deg) / pitch_deg;
        return mean_squared(at + kFromDeg / pitch_deg, at + kToDeg / pitch_deg) -
               mean_squared(at - kTopDeg / pitch_deg, at + kTopDeg / pitch_deg);
    };
    std::vector<double> differences;
    for (double cycle = 1; (cycle + 2) * 720 < double(squared_.size()) * pitch_deg; ++cycle) {
        double difference = 0;
        for (double deg : tdc) difference += speeding_up(cycle * 720 + deg) - speeding_up(cycle * 720 + deg + 360);
        if (std::isfinite(difference)) differences.push_back(difference);
    }
    answer.cycles = differences.size();
    if (answer.cycles < kLeastCycles) return answer;
    const double count = double(answer.cycles);
    double mean = 0, squares = 0;
    for (double d : differences) mean += d / count;
    for (double d : differences) squares += (d - mean) * (d - mean);
    answer.parity = mean > 0 ? 0 : 1;
    answer.sds = squares > 0 ? std::abs(mean) / std::sqrt(squares / (count - 1) / count) : 0;
    const double agree = double(std::count_if(differences.begin(), differences.end(), [&](double d) { return (d > 0) == (mean > 0); }));
    answer.clear = answer.sds > kClearSds && agree >= kClearShare * count;
    return answer;
}

} // namespace sixdeg
