// SPDX-License-Identifier: MIT
#include "score/balance_score.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "score/afr_score.hpp"

namespace sixdeg {
namespace {

constexpr std::size_t kMeanOf = 4; // cycles
constexpr double kBalancedPercent = 3;

double mean_from(const std::vector<double> &x, std::size_t at, std::size_t count) {
    return std::accumulate(x.begin() + long(at), x.begin() + long(at + count), 0.0) / double(count);
}

/// Trims that give all cylinders the same fuel; their mean is 0.
std::vector<double> wanted(const std::vector<double> &injector) {
    double inverse = 0;
    for (double f : injector) inverse += 1 / f / double(injector.size());
    std::vector<double> trim;
    for (double f : injector) trim.push_back(1 / f / inverse - 1);
    return trim;
}

} // namespace

void BalanceScore::cycle(const BalanceCycle &cycle) {
    if (cycle.on && !on_) {
        since_ = spread_.size(), ever_ = true;
        least_.assign(cycle.trim.size(), 1e9), wrong_way_ = 0, gave_up_ = -1;
    }
    on_ = cycle.on;
    spread_.push_back(spread_percent(cycle.lambda));
    distance_.push_back(distance_percent(cycle.lambda));
    if (on_) take_trims(cycle);
}

void BalanceScore::take_trims(const BalanceCycle &cycle) {
    if (cycle.gave_up && gave_up_ < 0) gave_up_ = double(spread_.size() - since_);
    const std::vector<double> goal = wanted(cycle.injector);
    for (std::size_t i = 0; i < goal.size(); ++i) {
        const double away = 100 * std::abs(cycle.trim[i] - goal[i]);
        least_[i] = std::min(least_[i], away);
        wrong_way_ = std::max(wrong_way_, away - least_[i]);
    }
}

std::optional<BalanceFigures> BalanceScore::result() const {
    if (!ever_ || since_ < kMeanOf || spread_.size() < since_ + kMeanOf) return std::nullopt;
    BalanceFigures b{mean_from(spread_, since_ - kMeanOf, kMeanOf), -1, 0, 0, wrong_way_, gave_up_};
    for (std::size_t at = since_; at + kMeanOf <= spread_.size(); ++at) {
        const double mean = mean_from(spread_, at, kMeanOf);
        b.largest_spread_percent = std::max(b.largest_spread_percent, mean);
        if (mean < kBalancedPercent && b.cycles_to_3_percent < 0) b.cycles_to_3_percent = double(at + kMeanOf - since_);
    }
    const std::size_t last = std::min(keep_, spread_.size() - since_);
    b.residual_percent = mean_from(distance_, distance_.size() - last, last);
    return b;
}

} // namespace sixdeg
