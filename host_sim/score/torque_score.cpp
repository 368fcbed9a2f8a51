// SPDX-License-Identifier: MIT
#include "score/torque_score.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/linalg.hpp"
#include "plant/engine/units.hpp"

namespace sixdeg {
namespace {

/// 1, cos(a/2), sin(a/2), cos(a), sin(a) ...: the cycle's harmonics, each from the one before.
Eigen::VectorXd basis(int harmonics, double angle_rad) {
    Eigen::VectorXd f(2 * harmonics + 1);
    f(0) = 1;
    const double c = std::cos(angle_rad / 2), s = std::sin(angle_rad / 2);
    for (double h = 1, u = c, v = s; h <= harmonics; ++h) {
        f(2 * int(h) - 1) = u;
        f(2 * int(h)) = v;
        const double next = u * c - v * s;
        v = v * c + u * s, u = next;
    }
    return f;
}

/// Coefficients of a waveform given at equal steps over the cycle.
Eigen::VectorXd project(int harmonics, const std::vector<double> &wave) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(2 * harmonics + 1);
    const double count = double(wave.size());
    for (std::size_t i = 0; i < wave.size(); ++i)
        sum += wave[i] * basis(harmonics, 4 * kPi * double(i) / count);
    sum *= 2 / count;
    sum(0) /= 2;
    return sum;
}

/// Angle by which the harmonics of `late` follow those of `early`, where their correlation is largest. Means
/// are left out.
double shift_rad(int harmonics, const Eigen::VectorXd &early, const Eigen::VectorXd &late) {
    const auto correlation = [&](double shift, double &slope, double &bend) {
        double value = slope = bend = 0;
        for (int h = 1; h <= harmonics; ++h) {
            const double a = early(2 * h - 1), b = early(2 * h), u = late(2 * h - 1), v = late(2 * h),
                         rate = h / 2.0;
            const double c = std::cos(rate * shift), s = std::sin(rate * shift), in = a * u + b * v,
                         across = a * v - b * u;
            value += in * c + across * s;
            slope += rate * (across * c - in * s);
            bend -= rate * rate * (in * c + across * s);
        }
        return value;
    };
    double best = 0, highest = -1e300, slope, bend;
    for (int deg = -45; deg <= 45; ++deg) {
        const double value = correlation(deg * kRadPerDeg, slope, bend);
        if (value > highest) highest = value, best = deg * kRadPerDeg;
    }
    for (int i = 0; i < 8; ++i) { // Newton, from within a degree
        correlation(best, slope, bend);
        if (bend < 0) best -= slope / bend;
    }
    return best;
}

} // namespace

void TorqueScore::steps(const std::vector<StepTruth> &truths) {
    for (auto from = truths.begin(); from != truths.end();) {
        const std::int64_t step = std::llround(from->angle_rad / (4 * kPi) * steps_);
        const std::int64_t cycle = std::int64_t(std::floor(double(step) / steps_)), left = (cycle + 1) * steps_ - step;
        const auto to = from + std::min(std::ptrdiff_t(left), truths.end() - from);
        std::vector<double> &into = steps_nm_[cycle];
        into.reserve(std::size_t(steps_));
        for (; from != to; ++from) into.push_back(from->net_torque_nm);
    }
}

void TorqueScore::edge(double crank_deg, double true_nm, double estimate_nm, bool settled) {
    const std::int64_t cycle = std::int64_t(std::floor(crank_deg / 720));
    if (cycle != cycle_) {
        close();
        cycle_ = cycle;
        settled_ = true;
    }
    settled_ &= settled;
    if (settled_)
        current_.teeth.push_back({(crank_deg - 720 * double(cycle)) * kRadPerDeg, true_nm, estimate_nm});
}

void TorqueScore::close() {
    const auto steps = steps_nm_.find(cycle_);
    // The first cycle of a run lacks its beginning.
    if (settled_ && steps != steps_nm_.end() && steps->second.size() == std::size_t(steps_)) {
        current_.steps_nm = std::move(steps->second);
        kept_.push_back(std::move(current_));
        if (kept_.size() > keep_) kept_.pop_front();
    }
    current_ = {};
    steps_nm_.erase(steps_nm_.begin(), steps_nm_.upper_bound(cycle_));
}

std::optional<TorqueFigures> TorqueScore::result() const {
    if (kept_.empty()) return std::nullopt;
    std::vector<double> wave(std::size_t(steps_), 0.0);
    for (const Cycle &cycle : kept_) {
        for (std::size_t i = 0; i < wave.size(); ++i) wave[i] += cycle.steps_nm[i] / double(kept_.size());
    }
    const Eigen::VectorXd truth = project(harmonics_, wave);
    const int n = int(truth.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    double from_true = 0, from_projection = 0, left_out = 0, teeth = 0;
    for (const Cycle &cycle : kept_) {
        for (const Tooth &tooth : cycle.teeth) {
            const Eigen::VectorXd f = basis(harmonics_, tooth.angle_rad);
            normal.selfadjointView<Eigen::Lower>().rankUpdate(f);
            right += f * tooth.estimate_nm;
            from_true += std::pow(tooth.estimate_nm - tooth.true_nm, 2);
            from_projection += std::pow(tooth.estimate_nm - truth.dot(f), 2);
            ++teeth;
        }
    }
    for (std::size_t i = 0; i < wave.size(); ++i) {
        left_out += std::pow(wave[i] - truth.dot(basis(harmonics_, 4 * kPi * double(i) / steps_)), 2);
    }
    const auto [low, high] = std::minmax_element(wave.begin(), wave.end());
    const double pp = *high - *low;
    // Least squares, since the teeth leave gaps where the mark is.
    const Eigen::VectorXd estimate = linalg::solve_symmetric(normal, right);
    return TorqueFigures{int(kept_.size()),
                         pp,
                         100 * std::sqrt(from_true / teeth) / pp,
                         100 * std::sqrt(from_projection / teeth) / pp,
                         100 * std::sqrt(left_out / steps_) / pp,
                         shift_rad(harmonics_, truth, estimate) * kDegPerRad};
}

} // namespace sixdeg
