// SPDX-License-Identifier: MIT
#include "score/afr_score.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sixdeg {
namespace {

constexpr double kBalancedPercent = 3;

double mean_of(const std::vector<double> &x) {
    return std::accumulate(x.begin(), x.end(), 0.0) / double(x.size());
}

std::size_t farthest(const std::vector<double> &x) {
    const double mean = mean_of(x);
    std::size_t best = 0;
    for (std::size_t i = 1; i < x.size(); ++i) {
        if (std::abs(x[i] - mean) > std::abs(x[best] - mean)) best = i;
    }
    return best;
}

} // namespace

double spread_percent(const std::vector<double> &x) {
    const auto [low, high] = std::minmax_element(x.begin(), x.end());
    return 100 * (*high - *low) / mean_of(x);
}

double distance_percent(const std::vector<double> &x) {
    const double mean = mean_of(x);
    double sum = 0;
    for (double v : x) sum += std::abs(v - mean);
    return 100 * sum / mean / double(x.size());
}

void AfrScore::cycle(const std::vector<double> &truth, const std::vector<double> &estimate, double stated_sd) {
    kept_.push_back({truth, estimate, stated_sd});
    if (kept_.size() > keep_) kept_.pop_front();
}

std::optional<AfrFigures> AfrScore::estimate() const {
    if (kept_.empty()) return std::nullopt;
    const std::size_t n = kept_.front().truth.size();
    std::vector<double> bias(n, 0.0);
    AfrFigures f{int(kept_.size()), 0, 0, 0, 0, 0, {}};
    const double count = double(kept_.size());
    for (const Cycle &c : kept_) {
        const double mean = mean_of(c.truth);
        for (std::size_t i = 0; i < n; ++i) {
            const double error = 100 * (c.estimate[i] - c.truth[i]) / mean;
            f.rms_points += error * error / (count * double(n));
            bias[i] += error / count;
        }
        f.stated_points += 100 * c.stated_sd / count;
        f.spread_percent += spread_percent(c.truth) / count;
        if (spread_percent(c.truth) > kBalancedPercent)
            f.wrong_cylinder_percent += 100 * (farthest(c.truth) != farthest(c.estimate)) / count;
    }
    f.rms_points = std::sqrt(f.rms_points);
    for (double b : bias) f.bias_points = std::max(f.bias_points, std::abs(b));
    f.bias_by_cylinder = std::move(bias);
    return f;
}

} // namespace sixdeg
