// SPDX-License-Identifier: MIT
#include "studies/airpath/matched_false.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

#include "common/progress.hpp"

namespace sixdeg {
namespace {

constexpr double kRunS = 60, kStepsPerHour = 3600 / kMatchedPeriodS;
constexpr double kNever = 9999; ///< A threshold that is not passed.
constexpr int kSparse = 10;     ///< One excursion of so many is followed.
constexpr long kLongest = 2000; ///< Steps of a copy.

using Shift = Eigen::Vector3d;

/// Mean residuals after 3 s of a noise that is constant.
Eigen::Vector2d response(const MatchedSetup &setup, const MatchedNoise &noise) {
    RandomStream random(1, 1);
    MatchedRun run(setup, kNever, kNever, random);
    for (int i = 0; i < 400; ++i) run.step(noise);
    return {run.bank().residual[0], run.bank().residual[1]};
}

/// The smallest shift of the noise that gives the residuals a hypothesis's mean.
std::array<Shift, 4> shifts(const MatchedSetup &setup) {
    Eigen::Matrix<double, 2, 3> gain;
    const Eigen::Vector2d at_rest = response(setup, {0, 0, 0});
    for (int i = 0; i < 3; ++i) {
        MatchedNoise noise{0, 0, 0};
        noise[std::size_t(i)] = 0.5;
        gain.col(i) = (response(setup, noise) - at_rest) / 0.5;
    }
    const Eigen::Matrix2d gram = gain * gain.transpose();
    std::array<Shift, 4> found;
    for (std::size_t l = 0; l < 4; ++l) {
        const std::size_t residual = l < 2 ? 1 : 0;
        Eigen::Vector2d mean = Eigen::Vector2d::Zero();
        mean(Eigen::Index(residual)) = setup.design.sign[residual] * setup.design.mean_kpa[residual] * (l % 2 ? -1 : 1);
        found[l] = gain.transpose() * gram.inverse() * mean;
    }
    return found;
}

/// One copy: at each threshold the likelihood ratio where it was first passed, else 0.
std::vector<double> follow(MatchedRun copy, std::size_t hypothesis, const Shift &shift, const std::vector<double> &thresholds,
    RandomStream &random) {
    std::vector<double> weight(thresholds.size(), 0);
    double log_ratio = 0;
    std::size_t passed = 0;
    for (long i = 0; i < kLongest && passed < thresholds.size(); ++i) {
        MatchedNoise noise = draw_noise(random);
        for (std::size_t j = 0; j < 3; ++j) {
            const double s = shift(Eigen::Index(j));
            noise[j] += s;
            log_ratio -= s * noise[j] - s * s / 2;
        }
        copy.step(noise);
        const float *g = copy.bank().cusum.g;
        if (!(g[hypothesis] > 0)) break;
        double other = 0;
        for (std::size_t l = 0; l < 4; ++l)
            if (l != hypothesis) other = std::max(other, double(g[l]));
        while (passed < thresholds.size() && g[hypothesis] - other > thresholds[passed]) weight[passed++] = std::exp(log_ratio);
    }
    return weight;
}

} // namespace

FalseAlarms count_false_alarms(const MatchedSetup &setup, double threshold, double hours, std::uint64_t seed) {
    RandomStream random(seed, 1);
    FalseAlarms found;
    long steps = 0;
    Progress progress("healthy running", hours * kStepsPerHour, Progress::share);
    for (; double(steps) < hours * kStepsPerHour; progress.at(double(steps))) {
        MatchedRun run(setup, threshold, threshold, random);
        while (!run.decides()) run.step(draw_noise(random));
        for (int i = 0; i < int(kRunS / kMatchedPeriodS); ++i, ++steps) {
            run.step(draw_noise(random));
            if (run.out().fault == SD_AIRPATH_NO_FAULT) continue;
            found.alarms++;
            break;
        }
    }
    found.hours = double(steps) / kStepsPerHour;
    return found;
}

std::vector<AlarmRate> sample_alarm_rates(const MatchedSetup &setup, const std::vector<double> &thresholds, double hours,
    std::uint64_t seed) {
    const auto shift = shifts(setup);
    RandomStream random(seed, 2), tilted(seed, 3);
    std::vector<double> sum(thresholds.size(), 0), squares(thresholds.size(), 0);
    long steps = 0, count = 0;
    Progress progress("importance sampling", hours * kStepsPerHour, Progress::share);
    for (; double(steps) < hours * kStepsPerHour; progress.at(double(steps))) {
        MatchedRun run(setup, kNever, kNever, random);
        while (!run.decides()) run.step(draw_noise(random));
        for (int i = 0; i < int(kRunS / kMatchedPeriodS); ++i, ++steps) {
            run.step(draw_noise(random));
            for (std::size_t l = 0; l < 4; ++l) {
                if (run.bank().cusum.n[l] != 1 || count++ % kSparse != 0) continue;
                const auto weight = follow(run, l, shift[l], thresholds, tilted);
                for (std::size_t t = 0; t < thresholds.size(); ++t) sum[t] += weight[t], squares[t] += weight[t] * weight[t];
            }
        }
    }
    std::vector<AlarmRate> rates;
    const double whole = double(steps) / kStepsPerHour;
    for (std::size_t t = 0; t < thresholds.size(); ++t)
        rates.push_back({thresholds[t], kSparse * sum[t] / whole, kSparse * std::sqrt(squares[t]) / whole});
    return rates;
}

double threshold_for(const std::vector<AlarmRate> &rates, double per_hour) {
    for (std::size_t i = 0; i < rates.size(); ++i) {
        if (!(rates[i].per_hour > 0) || rates[i].per_hour > per_hour) continue;
        if (i == 0) return rates[0].threshold;
        const double high = std::log(rates[i - 1].per_hour), low = std::log(rates[i].per_hour), at = std::log(per_hour);
        return rates[i - 1].threshold + (high - at) / (high - low) * (rates[i].threshold - rates[i - 1].threshold);
    }
    return 0;
}

} // namespace sixdeg
