// SPDX-License-Identifier: MIT
#include "studies/misfire/equal_alarms.hpp"

#include <algorithm>
#include <limits>

namespace sixdeg {

AlarmCurve::Found &AlarmCurve::Found::operator+=(const Found &other) {
    found += other.found, missed += other.missed, alarms += other.alarms, healthy += other.healthy;
    return *this;
}

void AlarmCurve::add(double score, bool judged, bool misfire) {
    ++(misfire ? missed_count_ : healthy_count_);
    if (judged) (misfire ? missed_ : healthy_).push_back(score);
}

void AlarmCurve::sort() {
    std::sort(healthy_.begin(), healthy_.end());
    std::sort(missed_.begin(), missed_.end());
}

AlarmCurve::Found AlarmCurve::found_at(double false_share) const {
    const auto allowed = std::size_t(false_share * double(healthy_count_));
    // A firing is an alarm below the limit, so the first healthy firing that may not be one is the limit.
    const double limit = allowed < healthy_.size() ? healthy_[allowed] : std::numeric_limits<double>::infinity();
    const auto below = [&](const std::vector<double> &scores) {
        return std::uint64_t(std::lower_bound(scores.begin(), scores.end(), limit) - scores.begin());
    };
    return {below(missed_), missed_count_, below(healthy_), healthy_count_};
}

} // namespace sixdeg
