// SPDX-License-Identifier: MIT
// How well any estimator could know each firing's torque: the posterior Cramer-Rao bound of the linear tooth-time model
// (kalman_design.hpp), in information form with QR, double precision.
//
// Unknown: phase and energy at the start (nothing known), the constant torque (a walk), the torque of every single
// firing (a walk from cycle to cycle), and the error of each tooth that learning left, which stays for the whole window.
// Linear and Gaussian, the bound is reached by the exact posterior: no filter that sees the same edges does better.
#pragma once
#include "design/torque/kalman_design.hpp"

namespace sixdeg {

struct BoundNoise {
    double edge_rad;      ///< New at each edge: jitter and the timer's rounding.
    double pattern_rad;   ///< Of each tooth, for good; 0: none.
    double constant_walk; ///< As in ToothNoise.
    double firing_change;
};

/// Standard deviation of a firing less the mean of all firings of its cycle, rms over the cylinders, normalised to
/// J_mean w^2; of the mean of the last `mean_cycles` cycles of a window of `window_cycles`, at the window's end.
double firing_bound(const ToothModel &model, const BoundNoise &noise, int mean_cycles, int window_cycles);

} // namespace sixdeg
