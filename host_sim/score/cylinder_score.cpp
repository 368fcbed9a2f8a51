// SPDX-License-Identifier: MIT
#include "score/cylinder_score.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

extern "C" {
#include "sd_status.h"
}

namespace sixdeg {
namespace {

template <class T> void keep_last(std::deque<T> &values, T value, std::size_t keep) {
    values.push_back(value);
    if (values.size() > keep) values.pop_front();
}

double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

} // namespace

void CylinderScore::truth(const CycleTruth &cycle) {
    keep_last(cylinders_[std::size_t(cycle.cylinder - 1)].truth, cycle.combustion_torque_nm, keep_);
}

void CylinderScore::estimate(const sd_signals_t &signals, std::uint8_t health) {
    if (health == SD_INVALID) return;
    for (std::size_t i = 0; i < cylinders_.size(); ++i) {
        keep_last(cylinders_[i].estimate,
                  {double(signals.cycle_cylinder_torque_nm[i]), double(signals.cycle_cylinder_sd_nm[i])}, keep_);
    }
}

std::optional<CylinderFigures> CylinderScore::result() const {
    CylinderFigures f{};
    f.cycles = int(cylinders_.front().estimate.size());
    for (const Cylinder &c : cylinders_) {
        if (c.truth.empty() || c.estimate.empty()) return std::nullopt;
        f.true_nm.push_back(std::accumulate(c.truth.begin(), c.truth.end(), 0.0) / double(c.truth.size()));
        Estimate sum{};
        for (const Estimate &e : c.estimate) sum = {sum.torque_nm + e.torque_nm, sum.sd_nm + e.sd_nm};
        f.estimate_nm.push_back(sum.torque_nm / double(c.estimate.size()));
        f.sd_nm.push_back(sum.sd_nm / double(c.estimate.size()));
    }
    const double truth = mean(f.true_nm), estimate = mean(f.estimate_nm);
    if (!(truth > 0)) return std::nullopt; // percent of nothing
    f.mean_error_percent = 100 * (estimate - truth) / truth;
    double square = 0;
    for (std::size_t i = 0; i < f.true_nm.size(); ++i) {
        const double error = 100 * ((f.estimate_nm[i] - estimate) - (f.true_nm[i] - truth)) / truth;
        f.imbalance_percent = std::max(f.imbalance_percent, std::abs(error));
        square += error * error;
    }
    f.imbalance_rms_percent = std::sqrt(square / double(f.true_nm.size()));
    return f;
}

} // namespace sixdeg
