// SPDX-License-Identifier: MIT
#include "score/misfire_score.hpp"

#include <algorithm>
#include <cmath>

extern "C" {
#include "sd_misfire.h"
}

namespace sixdeg {
namespace {

/// Probability of `most` or fewer hits in `trials`.
double binomial_up_to(std::uint64_t most, std::uint64_t trials, double p) {
    const double n = double(trials);
    double sum = 0;
    // Terms more than some 40 deviations from the middle vanish.
    const double middle = n * p, reach = 40 * std::sqrt(n * p * (1 - p)) + 40;
    for (std::uint64_t k = std::uint64_t(std::max(0.0, middle - reach)); k <= most; ++k) {
        const double x = double(k);
        sum += std::exp(std::lgamma(n + 1) - std::lgamma(x + 1) - std::lgamma(n - x + 1) + x * std::log(p) + (n - x) * std::log1p(-p));
        if (x > middle + reach) break;
    }
    return std::min(1.0, sum);
}

/// p in (0, 1) at which the rising `f` passes `level`.
template <class F> double solve(F f, double level) {
    double low = 1e-12, high = 1 - 1e-12;
    for (int i = 0; i < 60; ++i) (f((low + high) / 2) < level ? low : high) = (low + high) / 2;
    return (low + high) / 2;
}

double spread(double sum, double squares, std::uint64_t n) {
    return std::sqrt(std::max(0.0, squares / double(n) - std::pow(sum / double(n), 2)));
}

} // namespace

RateBounds rate_bounds(std::uint64_t hits, std::uint64_t trials) {
    if (trials == 0) return {0, 1};
    RateBounds bounds{0, 1};
    if (hits > 0) bounds.low = solve([&](double p) { return 1 - binomial_up_to(hits - 1, trials, p); }, 0.025);
    if (hits < trials) bounds.high = solve([&](double p) { return 1 - binomial_up_to(hits, trials, p); }, 0.975);
    return bounds;
}

double MisfireFigures::separation() const {
    if (healthy == 0 || missed == 0) return 0;
    return (index_sum / double(healthy) - missed_sum / double(missed)) / ((healthy_sd() + missed_sd()) / 2);
}

double MisfireFigures::healthy_sd() const { return healthy ? spread(index_sum, index_square_sum, healthy) : 0; }
double MisfireFigures::missed_sd() const { return missed ? spread(missed_sum, missed_square_sum, missed) : 0; }

std::size_t MisfireScore::lane_of(const EngineFile &engine, int cylinder) {
    const auto &order = engine.firing_order;
    return std::size_t(std::find(order.begin(), order.end(), cylinder) - order.begin());
}

std::int64_t MisfireScore::firing_number(std::int64_t cycle, int cylinder) const {
    return cycle * engine_.cylinders() + std::int64_t(lane(cylinder));
}

std::int64_t MisfireScore::cycle_of(const EngineFile &engine, double crank_deg, int cylinder) {
    return std::int64_t(std::floor((crank_deg - engine.firing_tdc_deg[lane_of(engine, cylinder)]) / 720));
}

void MisfireScore::said(double crank_deg, int cylinder, int verdict, double index) {
    said_[firing_number(cycle_of(engine_, crank_deg, cylinder), cylinder)] = {verdict, index};
}

void MisfireScore::truth(const CycleTruth &cycle) { burned_[firing_number(cycle.cycle, cycle.cylinder)] = cycle.burned_fraction; }

const std::pair<int, double> *MisfireScore::verdict(std::int64_t cycle, int cylinder) const {
    const auto found = said_.find(firing_number(cycle, cylinder));
    return found == said_.end() ? nullptr : &found->second;
}

MisfireFigures MisfireScore::result() const {
    MisfireFigures f;
    const auto overlooked = [&](std::int64_t firing) {
        const auto burned = burned_.find(firing);
        const auto verdict = said_.find(firing);
        return burned != burned_.end() && burned->second < 0.5 && verdict != said_.end() &&
               verdict->second.first != SD_MISFIRE && verdict->second.first != SD_NOT_JUDGED;
    };
    for (const auto &[firing, burned] : burned_) {
        const auto found = said_.find(firing);
        if (found == said_.end() || found->second.first == SD_NOT_JUDGED) {
            ++f.not_judged;
            f.not_judged_misfires += burned < 0.5;
            continue;
        }
        const auto [verdict, index] = found->second;
        if (burned < 0.5) {
            ++f.missed;
            f.detected += verdict == SD_MISFIRE;
            f.missed_sum += index, f.missed_square_sum += index * index;
        } else if (burned < 0.9) {
            ++f.partial;
            f.partial_found += verdict == SD_PARTIAL_BURN;
            f.partial_as_misfire += verdict == SD_MISFIRE;
        } else {
            ++f.healthy;
            f.healthy_as_partial += verdict == SD_PARTIAL_BURN;
            f.index_sum += index, f.index_square_sum += index * index;
            if (verdict != SD_MISFIRE) continue;
            ++f.false_alarms;
            f.wrong_cylinder += overlooked(firing - 1) || overlooked(firing + 1);
        }
    }
    return f;
}

} // namespace sixdeg
