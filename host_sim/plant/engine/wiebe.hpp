// SPDX-License-Identifier: MIT
// Heat release of one pulse: Wiebe's function.
#pragma once
#include <cmath>

namespace sixdeg {

/// x_b(theta) = 1 - exp(-a y^(m+1)), y = (theta - start)/duration, a = 6.908: 99.9 % burned at y = 1
/// (Heywood, Internal Combustion Engine Fundamentals, eq. 9.31). The pulse runs on until 1 - x_b is 1e-7, so
/// that no jump in its rate spoils the energy balance.
struct WiebePulse {
    double start_rad = 0, duration_rad = 1, shape_m = 1,
           heat_j = 0; ///< start from firing TDC; shape in [0.5, 5].

    static constexpr double kA = 6.907755278982137; // ln(1000)
    static constexpr double kLast = 16.118;         // a y^(m+1) where 1e-7 is left

    /// y^(m+1); the usual whole shapes without a logarithm.
    double power_of(double y) const {
        if (shape_m == 1) return y * y;
        if (shape_m == 2) return y * y * y;
        return std::exp((shape_m + 1) * std::log(y));
    }
    double end_rad() const { return start_rad + duration_rad * std::pow(kLast / kA, 1 / (shape_m + 1)); }
    /// Adds what has been released at theta from firing TDC, J, and its rate, J/rad.
    void add(double theta, double &rate, double &released) const {
        if (theta <= start_rad) return;
        const double y = (theta - start_rad) / duration_rad, spent = kA * power_of(y);
        if (spent >= kLast) {
            released += heat_j * (1 - 1e-7);
            return;
        }
        const double left = std::exp(-spent);
        released += heat_j * (1 - left);
        rate += heat_j * (shape_m + 1) * spent / (theta - start_rad) * left;
    }
};

} // namespace sixdeg
