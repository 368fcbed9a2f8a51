// SPDX-License-Identifier: MIT
#include "identify/learned_pattern.hpp"

#include <algorithm>
#include <cmath>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr double kRad = M_PI / 180, kTwoSided95 = 1.96;
// Speeds of which the firmware is told: so far apart, relative, that it takes the pattern for one and not for motored torque.
constexpr double kSpreadOfU = 0.5;

} // namespace

sd_kept_t kept_of(const Identified &found, const std::string &from) {
    if (!found.pattern_refused.empty() || found.pattern_deg.empty())
        throw InputError(from, "tooth pattern", "is not told, so there is nothing to keep: " + found.pattern_refused);
    sd_kept_t kept{};
    sd_pattern_sums_t &sums = kept.pattern;
    const double cycles = std::fmax(double(found.pattern_cycles), SD_PATTERN_CYCLES_MIN);
    double square = 0, variance = 0, teeth = 0;
    for (std::size_t p = 0; p < found.pattern_deg.size(); ++p) {
        const Found &tooth = found.pattern_deg[p];
        if (!tooth.told()) continue;
        const double late = tooth.value * kRad;
        sums.late[p] = sums.late_u[p] = float(cycles * late); // half of the cycles at u = 1 - spread, half at 1 + spread; no slope over u
        square += late * late;
        variance += std::pow(tooth.half_width * kRad / kTwoSided95, 2);
        teeth += 1;
    }
    sums.cycles = sums.u = float(cycles);
    sums.uu = float(cycles * (1 + kSpreadOfU * kSpreadOfU));
    // The firmware divides what the fit leaves of a tooth by the cycles, as far as their speeds differ.
    const double apart = kSpreadOfU * kSpreadOfU / (1 + kSpreadOfU * kSpreadOfU), left = variance / teeth * cycles * apart;
    sums.square = float(cycles * square / teeth + left * (cycles - 2));
    return kept;
}

} // namespace sixdeg
