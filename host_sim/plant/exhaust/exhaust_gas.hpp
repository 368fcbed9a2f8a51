// SPDX-License-Identifier: MIT
// The exhaust's gas and the one law by which it passes a hole. docs/theory/plant.md, section Exhaust.
#pragma once
#include <cmath>

namespace sixdeg::exhaust {

constexpr double kR = 287, kGamma = 1.34;
constexpr double kCp = kGamma * kR / (kGamma - 1), kCv = kCp - kR; ///< J/(kg K)

/// Mass flow per area times sqrt(R T_up)/p_up, for a pressure ratio down/up in [0, 1]: isentropic to the
/// throat, choked below the critical ratio. Above 0.98 it is a straight line to 0, where the square root has
/// no slope.
inline double orifice_psi(double ratio) {
    constexpr double kLinear = 0.98;
    static const double critical = std::pow(2 / (kGamma + 1), kGamma / (kGamma - 1));
    const auto isentropic = [](double r) {
        return std::sqrt(2 * kGamma / (kGamma - 1) *
                         (std::pow(r, 2 / kGamma) - std::pow(r, (kGamma + 1) / kGamma)));
    };
    static const double choked = isentropic(critical), at_linear = isentropic(kLinear);
    if (ratio <= critical) return choked;
    if (ratio >= kLinear) return at_linear * (1 - ratio) / (1 - kLinear);
    return isentropic(ratio);
}

/// kg/s through an effective area from an upstream state; both pressures in Pa, up >= down.
inline double orifice_kgps(double area_m2, double up_pa, double up_k, double down_pa) {
    return area_m2 * up_pa / std::sqrt(kR * up_k) * orifice_psi(down_pa / up_pa);
}

} // namespace sixdeg::exhaust
