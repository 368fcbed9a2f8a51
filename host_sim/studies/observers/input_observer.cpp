// SPDX-License-Identifier: MIT
#include "studies/observers/input_observer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sixdeg {
namespace {

constexpr int kRejectedInRowMax = 12;
constexpr double kLargest = 1e9;

bool below(double x, double limit) { return x > -limit && x < limit; } // false for NaN
bool within(double x, double above, double to) { return x > above && x <= to; }

} // namespace

InputObserver::InputObserver(const InputConfig &config) : config_(config) {
    bool fine = config.inputs >= 1 && within(config.noise, 0, 1e3) && within(config.start_speed, 0, 1e6) &&
                within(config.start_accel, 0, 1e6) && within(config.start_strength, 0, 1) && config.walk_strength >= 0 &&
                    config.walk_strength <= 1 && config.alarm_sd >= 3 &&
                config.alarm_sd <= 100;
    for (const auto &row : config.step.increment) fine = fine && below(row[0], 1e6) && below(row[1], 1e6);
    for (const double g : config.step.from_input) fine = fine && below(g, 1e6);
    if (!fine) throw std::invalid_argument("a field of the input observer is out of its range");
    state_.resize(std::size_t(config.inputs) + 2);
    covariance_.resize(states() * states());
}

/// x+ = F x along one row or column of the covariance, or for the state itself.
void InputObserver::transform(const std::vector<double> &input, double *x, std::size_t stride) const {
    double drive = 0;
    for (std::size_t n = 0; n < input.size(); ++n) drive += input[n] * x[(n + 2) * stride];
    const double v1 = x[0], v2 = x[stride];
    x[0] += config_.step.increment[0][0] * v1 + config_.step.increment[0][1] * v2 + config_.step.from_input[0] * drive;
    x[stride] += config_.step.increment[1][0] * v1 + config_.step.increment[1][1] * v2 + config_.step.from_input[1] * drive;
}

void InputObserver::predict(const std::vector<double> &input) {
    transform(input, state_.data(), 1);
    for (std::size_t j = 0; j < states(); ++j) transform(input, &p(0, j), states());
    for (std::size_t i = 0; i < states(); ++i) transform(input, &p(i, 0), 1);
    for (std::size_t i = 2; i < states(); ++i) p(i, i) += config_.walk_strength * config_.walk_strength;
}

/// Two samples in a row beyond the limit on the same side: one alone may be noise. What then changed is the strength of
/// the active cylinder while its input acts, and the crank itself where nothing else could have.
void InputObserver::watch(double squared, const std::vector<double> &input, std::size_t active) {
    const int side = squared <= config_.alarm_sd * config_.alarm_sd ? 0 : innovation_ > 0 ? 1 : -1;
    if (side != 0 && side == last_side_) {
        if (input[active] != 0) p(active + 2, active + 2) += 1;
        else p(1, 1) += config_.start_accel * config_.start_accel;
        ++alarms_;
    }
    last_side_ = side;
}

/// Kalman update, y sees state 0: P <- (I - K h) P (I - K h)' + K R K', symmetric and positive whatever rounding does.
void InputObserver::correct(double y, const std::vector<double> &input, std::size_t active) {
    const double variance = p(0, 0) + config_.noise * config_.noise;
    innovation_ = y - state_[0];
    watch(innovation_ * innovation_ / variance, input, active);
    std::vector<double> gain(states()), seen(states());
    for (std::size_t i = 0; i < states(); ++i) {
        seen[i] = p(0, i);
        gain[i] = seen[i] / variance;
        state_[i] += gain[i] * innovation_;
    }
    for (std::size_t i = 0; i < states(); ++i) {
        for (std::size_t j = 0; j <= i; ++j)
            p(i, j) = p(j, i) = p(i, j) - gain[i] * seen[j] - gain[j] * seen[i] + gain[i] * gain[j] * variance;
    }
}

bool InputObserver::sound() const {
    bool fine = true;
    for (std::size_t i = 0; i < states(); ++i) fine = fine && below(state_[i], kLargest) && p(i, i) > 0 && p(i, i) < kLargest * kLargest;
    return fine;
}

void InputObserver::stop() {
    std::fill(state_.begin(), state_.end(), 0.0);
    running_ = false;
    steps_ = 0, rejected_in_row_ = 0;
}

void InputObserver::start(double speed, double accel, const std::vector<double> &strengths) {
    stop();
    std::fill(covariance_.begin(), covariance_.end(), 0.0);
    innovation_ = 0, alarms_ = 0, last_side_ = 0;
    state_[0] = speed, state_[1] = accel;
    const double deviation[3] = {config_.start_speed, config_.start_accel, config_.start_strength};
    for (std::size_t i = 0; i < states(); ++i) {
        if (i >= 2) state_[i] = strengths.empty() ? 1.0 : strengths[i - 2];
        p(i, i) = deviation[std::min<std::size_t>(i, 2)] * deviation[std::min<std::size_t>(i, 2)];
    }
    if (sound()) running_ = true;
    else stop();
}

double InputObserver::step(double y, const std::vector<double> &input, int active) {
    const bool good = below(y, kLargest);
    bool usable = active >= 0 && active < config_.inputs && input.size() == std::size_t(config_.inputs);
    for (const double q : input) usable = usable && below(q, kLargest);
    if (good && usable) rejected_in_row_ = 0;
    else ++rejected_, ++rejected_in_row_;
    if (!running_) {
        if (good && usable) start(y, 0);
        return 0;
    }
    if (!usable || rejected_in_row_ > kRejectedInRowMax) {
        stop();
        return 0;
    }
    predict(input);
    if (good) correct(y, input, std::size_t(active));
    if (!sound()) stop();
    ++steps_;
    return state_[1];
}

double InputObserver::accel_sd() const { return std::sqrt(p(1, 1)); }
double InputObserver::strength_sd(int n) const { return std::sqrt(p(std::size_t(n) + 2, std::size_t(n) + 2)); }

sd_health_t InputObserver::health() const {
    if (!running_) return SD_INVALID;
    return steps_ < config_.settle_steps || rejected_in_row_ > 0 ? SD_DEGRADED : SD_VALID;
}

} // namespace sixdeg
