// SPDX-License-Identifier: MIT
// The hybrid engine of document 000. Linear, its equation (2), in closed form: v'' = -k2 v' - k1 v + C Q(t), with Q a pulse of constant
// power over the first part of every firing interval. Nonlinear, its equation (1), as restored in docs/results/observers.md: the whole
// interval is the pulse, and its power falls as the gas expands, with x_t / x to the adiabatic 1.4, x the piston's distance from the head.
// Shares nothing with the observers.
#pragma once
#include <cmath>
#include <functional>

namespace sixdeg {

/// Table 1 of the document, and what it leaves open (docs/results/observers.md).
struct HybridEngine {
    double k1_per_s2 = 900, k2_per_s = 20; ///< k1 > k2^2 / 4: it must oscillate.
    double speed_radps = 100, crank_radius_m = 0.035;
    double mean_input_mps3 = 0.3 / (20 * 0.0296) * 7457; ///< C Q over a whole firing interval.
    double pulse_deg = 45, interval_deg = 180;
    bool nonlinear = false;
    double head_m = 0.0296, adiabatic = 1.4; ///< x_t; nonlinear only.
    double interval_s() const { return interval_deg * M_PI / 180 / speed_radps; }
    double pulse_s() const { return pulse_deg * M_PI / 180 / speed_radps; }
    double pulse_input_mps3() const { return mean_input_mps3 * interval_deg / pulse_deg; }
    /// C Q of a firing at `since_s` from its TDC, m/s^3.
    double input_mps3(double since_s) const;
    /// Its mean from `from_s` to `to_s` after that TDC.
    double mean_input(double from_s, double to_s) const;
};

struct HybridState {
    double speed_mps = 0, accel_mps2 = 0;
};

/// Strength E of firing `k`, the first at time 0: 1 burns, 0 misfires.
using FiringStrength = std::function<double(long)>;

/// State `to_s` reached from `state` at `from_s`, exact: one closed form for each stretch of constant input.
HybridState hybrid_advance(const HybridEngine &engine, const FiringStrength &strength, HybridState state, double from_s,
                           double to_s);
/// Where a healthy engine is at the start of every firing.
HybridState hybrid_periodic_start(const HybridEngine &engine);

} // namespace sixdeg
