// SPDX-License-Identifier: MIT
#include "score/firing_score.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace sixdeg {

/// Errors of all firings of a cycle, the cycle's mean taken out; of one cylinder, whose mean is itself, as they are.
struct FiringScore::Cycle {
    Eigen::ArrayXd single, mean, single_sd, mean_sd;
    double bias = 0, truth = 0, speed = 0;
    int invalid = 0;
};

void FiringScore::said(double crank_deg, int cylinder, double torque_nm, double sd_nm, double mean_nm, double mean_sd_nm,
                       bool valid) {
    const auto &order = engine_.firing_order;
    const auto lane = std::size_t(std::find(order.begin(), order.end(), cylinder) - order.begin());
    if (lane == order.size()) return;
    const auto cycle = std::int64_t(std::floor((crank_deg - engine_.firing_tdc_deg[lane]) / 720));
    said_[{cycle, lane}] = {torque_nm, sd_nm, mean_nm, mean_sd_nm, valid};
}

void FiringScore::truth(const CycleTruth &cycle) {
    const auto &order = engine_.firing_order;
    const auto lane = std::size_t(std::find(order.begin(), order.end(), cycle.cylinder) - order.begin());
    truth_[{cycle.cycle, lane}] = {cycle.combustion_torque_nm, cycle.tdc_speed_radps};
}

std::optional<double> FiringScore::mean_truth(const Key &last) const {
    double sum = 0;
    for (int back = 0; back < kMeanCycles; ++back) {
        const auto found = truth_.find({last.first - back, last.second});
        if (found == truth_.end()) return std::nullopt;
        sum += found->second.torque_nm / kMeanCycles;
    }
    return sum;
}

std::optional<FiringScore::Cycle> FiringScore::cycle_at(std::int64_t number) const {
    const auto n = Eigen::Index(engine_.cylinders());
    Cycle cycle{Eigen::ArrayXd(n), Eigen::ArrayXd(n), Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
    for (Eigen::Index lane = 0; lane < n; ++lane) {
        const Key key{number, std::size_t(lane)};
        const auto said = said_.find(key);
        const auto mean = mean_truth(key);
        if (said == said_.end() || !mean) return std::nullopt;
        const double truth = truth_.at(key).torque_nm;
        cycle.speed += truth_.at(key).speed_radps / double(n);
        cycle.single(lane) = said->second.torque_nm - truth, cycle.single_sd(lane) = said->second.sd_nm;
        cycle.mean(lane) = said->second.mean_nm - *mean, cycle.mean_sd(lane) = said->second.mean_sd_nm;
        cycle.truth += truth / double(n);
        cycle.invalid += !said->second.valid;
    }
    cycle.bias = cycle.single.mean();
    if (n > 1) {
        cycle.single -= cycle.single.mean();
        cycle.mean -= cycle.mean.mean();
    }
    return cycle;
}

std::optional<FiringFigures> FiringScore::result() const {
    if (said_.empty()) return std::nullopt;
    FiringFigures figures;
    double single = 0, mean = 0, single_stated = 0, mean_stated = 0;
    for (std::int64_t number = said_.begin()->first.first + kSettleCycles; number <= said_.rbegin()->first.first; ++number) {
        const auto cycle = cycle_at(number);
        if (!cycle) continue;
        figures.invalid += std::size_t(cycle->invalid);
        if (cycle->invalid > 0) continue;
        ++figures.cycles;
        figures.mean_nm += cycle->truth;
        figures.mean_radps += cycle->speed;
        figures.bias_percent += cycle->bias;
        single += cycle->single.square().mean(), single_stated += cycle->single_sd.square().mean();
        mean += cycle->mean.square().mean(), mean_stated += cycle->mean_sd.square().mean();
        figures.single_max_percent = std::max(figures.single_max_percent, cycle->single.abs().maxCoeff());
        figures.imbalance_max_percent = std::max(figures.imbalance_max_percent, cycle->mean.abs().maxCoeff());
    }
    if (figures.cycles == 0 || !(figures.mean_nm > 0)) return std::nullopt; // percent of nothing say nothing
    figures.mean_nm /= figures.cycles;
    figures.mean_radps /= figures.cycles;
    const double percent = 100 / figures.mean_nm;
    figures.bias_percent *= percent / figures.cycles;
    figures.single_percent = percent * std::sqrt(single / figures.cycles);
    figures.imbalance_percent = percent * std::sqrt(mean / figures.cycles);
    figures.single_max_percent *= percent, figures.imbalance_max_percent *= percent;
    figures.single_honesty = std::sqrt(single / single_stated);
    figures.imbalance_honesty = std::sqrt(mean / mean_stated);
    return figures;
}

} // namespace sixdeg
