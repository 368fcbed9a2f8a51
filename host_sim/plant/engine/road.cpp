// SPDX-License-Identifier: MIT
#include "plant/engine/road.hpp"

#include <cmath>

#include "plant/engine/units.hpp"

namespace sixdeg {

RoughRoad::RoughRoad(double rms_nm, double low_hz, double high_hz, RandomStream random)
    : amplitude_nm_(rms_nm * std::sqrt(2.0 / kSines)) {
    for (std::size_t i = 0; i < kSines; ++i) {
        const double place = (double(i) + random.uniform()) / kSines;
        frequency_radps_[i] = 2 * kPi * (low_hz + (high_hz - low_hz) * place);
        phase_[i] = 2 * kPi * random.uniform();
    }
}

double RoughRoad::at(double t) const {
    double sum = 0;
    for (std::size_t i = 0; i < kSines; ++i) sum += std::sin(frequency_radps_[i] * t + phase_[i]);
    return amplitude_nm_ * sum;
}

Profile::Segment RoughRoad::segment(double t) const {
    if (amplitude_nm_ == 0) return {-1e300, 1e300, 0, 0};
    const double from = std::floor(t / kPeriod) * kPeriod, to = from + kPeriod, value = at(from);
    return {from, to, value, (at(to) - value) / kPeriod};
}

} // namespace sixdeg
