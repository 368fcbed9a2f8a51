// SPDX-License-Identifier: MIT
#include "studies/driveline/drive_score.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

constexpr double kMatchS = 0.1;

void fill_delays(std::vector<double> delays, DriveFigures &figures) {
    if (delays.empty()) return;
    double sum = 0, squares = 0;
    for (double &d : delays) {
        sum += d;
        squares += d * d;
        d = std::abs(d);
    }
    std::sort(delays.begin(), delays.end());
    figures.delay_mean_s = sum / double(delays.size());
    figures.delay_rms_s = std::sqrt(squares / double(delays.size()));
    figures.delay_p95_s = delays[std::size_t(0.95 * double(delays.size() - 1))];
}

} // namespace

void DriveScore::pass(double now_s, double h, Location real) {
    if (now_s <= count_from_s_) return;
    all_s_ += h;
    (told_ ? counted_s_ : invalid_s_) += h;
    if (told_ && estimate_ != real) wrong_s_ += h;
}

void DriveScore::changed(const LocationChange &change) {
    if (told_ && change.time_s > count_from_s_) real_.push_back(change);
}

void DriveScore::said(double now_s, double weight_s, const sd_driveline_out_f32_t &out, double twist_error_rad, double shaft_error_nm) {
    const Location before = estimate_;
    estimate_ = out.location;
    told_ = out.status.health != SD_INVALID;
    if (now_s < count_from_s_ || !told_) return;
    if (estimate_ != before) found_.push_back({now_s, before, estimate_});
    twist_squares_ += twist_error_rad * twist_error_rad * weight_s;
    shaft_squares_ += shaft_error_nm * shaft_error_nm * weight_s;
    bias_sum_ += double(out.bias_nm) * weight_s;
    teeth_s_ += weight_s;
}

// Both what was there and what was found are in order of time.
DriveFigures DriveScore::figures() const {
    DriveFigures figures;
    std::vector<double> delays;
    std::vector<bool> used(found_.size(), false);
    std::size_t first = 0;
    for (const LocationChange &change : real_) {
        figures.transitions++;
        while (first < found_.size() && found_[first].time_s < change.time_s - kMatchS) first++;
        std::size_t best = found_.size();
        const auto distance = [&](std::size_t i) { return std::abs(found_[i].time_s - change.time_s); };
        for (std::size_t i = first; i < found_.size() && found_[i].time_s < change.time_s + kMatchS; ++i) {
            if (!used[i] && found_[i].to == change.to && (best == found_.size() || distance(i) < distance(best))) best = i;
        }
        if (best == found_.size()) {
            figures.missed++;
            continue;
        }
        used[best] = true;
        delays.push_back(found_[best].time_s - change.time_s);
    }
    for (const bool each : used) figures.extra += !each;
    fill_delays(std::move(delays), figures);
    figures.wrong_percent = 100 * wrong_s_ / counted_s_;
    figures.told_percent = 100 * (1 - invalid_s_ / all_s_);
    figures.twist_rms_rad = std::sqrt(twist_squares_ / teeth_s_);
    figures.shaft_rms_nm = std::sqrt(shaft_squares_ / teeth_s_);
    figures.bias_mean_nm = bias_sum_ / teeth_s_;
    return figures;
}

} // namespace sixdeg
