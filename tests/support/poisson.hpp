// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>
#include <cstdint>

namespace sixdeg::test {

/// The Poisson mean at which `count` events or fewer (upper), or as many or more (lower), have a chance of 2.5 %.
inline double poisson_bound(std::uint64_t count, bool upper) {
    if (!upper && count == 0) return 0;
    const auto at_most = [](std::uint64_t n, double mean) {
        double sum = 0;
        for (std::uint64_t k = 0; k <= n; ++k) sum += std::exp(double(k) * std::log(mean) - mean - std::lgamma(double(k) + 1));
        return sum;
    };
    double low = 1e-9, high = double(count) + 10 * std::sqrt(double(count) + 1) + 10;
    for (int i = 0; i < 80; ++i) {
        const double middle = (low + high) / 2;
        const bool too_small = upper ? at_most(count, middle) > 0.025 : 1 - at_most(count - 1, middle) < 0.025;
        (too_small ? low : high) = middle;
    }
    return high;
}

} // namespace sixdeg::test
