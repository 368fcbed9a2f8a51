// SPDX-License-Identifier: MIT
#include "score/work_score.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace sixdeg {
namespace {

constexpr std::size_t kLeast = 10;
constexpr std::int64_t kSettleCycles = 15; // until the scenario's load has found its level

Eigen::ArrayXd array_of(const std::vector<double> &values) {
    return Eigen::Map<const Eigen::ArrayXd>(values.data(), Eigen::Index(values.size()));
}

double rms(const Eigen::ArrayXd &x) { return x.size() > 0 ? std::sqrt(x.square().mean()) : 0; }

} // namespace

void WorkScore::said(double crank_deg, std::size_t lane, double work_j, double sd_j, std::optional<double> change_j) {
    if (lane >= engine_.firing_tdc_deg.size()) return;
    said_[{std::int64_t(std::floor((crank_deg - engine_.firing_tdc_deg[lane]) / 720)), lane}] = {work_j, sd_j, change_j};
}

void WorkScore::truth(const CycleTruth &cycle) {
    const auto &order = engine_.firing_order;
    truth_[{cycle.cycle, std::size_t(std::find(order.begin(), order.end(), cycle.cylinder) - order.begin())}] = cycle.work_j;
}

/// Of this firing and those before it, one of each cylinder.
std::optional<double> WorkScore::true_work(Key last) const {
    double sum = 0;
    for (std::size_t i = 0; i < engine_.firing_order.size(); ++i) {
        const auto found = truth_.find(last);
        if (found == truth_.end()) return std::nullopt;
        sum += found->second;
        last = last.second > 0 ? Key{last.first, last.second - 1} : Key{last.first - 1, engine_.firing_order.size() - 1};
    }
    return sum;
}

std::optional<WorkFigures> WorkScore::result() const {
    std::vector<double> said, stated, truth, change_errors;
    for (const auto &[key, value] : said_) {
        if (key.first < said_.begin()->first.first + kSettleCycles) continue;
        const auto work = true_work(key);
        const auto now = truth_.find(key), before = truth_.find({key.first - 1, key.second});
        if (work) said.push_back(value.work_j), stated.push_back(value.sd_j), truth.push_back(*work);
        if (value.change_j && now != truth_.end() && before != truth_.end())
            change_errors.push_back(*value.change_j - (now->second - before->second));
    }
    if (said.size() < kLeast) return std::nullopt;
    const Eigen::ArrayXd y = array_of(truth) - array_of(truth).mean(), x = array_of(said) - array_of(said).mean();
    WorkFigures figures;
    figures.cycles = int(said.size());
    figures.mean_j = array_of(truth).mean();
    const double percent = figures.mean_j > 0 ? 100 / figures.mean_j : 0, both = rms(x) * rms(y);
    figures.spread_percent = percent * rms(y);
    figures.correlation = both > 0 ? (x * y).mean() / both : 0;
    figures.rms_percent = percent * rms(x - y);
    figures.stated_percent = percent * rms(array_of(stated));
    figures.change_rms_percent = percent * double(engine_.firing_order.size()) * rms(array_of(change_errors));
    return figures;
}

} // namespace sixdeg
