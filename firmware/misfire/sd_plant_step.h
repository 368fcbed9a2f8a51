/* SPDX-License-Identifier: MIT */
/// sd_plant_step.h - one exact step of the crank of document 000, computed on the host, for one length of the step.
///
///   v1' = v2,  v2' = -k2 v2 - k1 v1 + C Q          v1: crank pin speed less its mean, m/s; C Q: input, m/s^3
///
/// With the input's mean over the step (and, for an observer, the output's) the step is x+ = x + D x + g u + h y,
/// D = exp(A T) - I. D, g and h come from the calibration: no exponential is needed on a target, and a D near zero
/// keeps its digits.
#ifndef SD_PLANT_STEP_H
#define SD_PLANT_STEP_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SD_PLANT_STEPS_MAX 8 ///< Lengths in a table.

/// SI units.
typedef struct sd_plant_step {
    uint32_t period_ticks;   ///< Length T of the step, >= 1.
    float    increment[2][2]; ///< D; finite, like all below.
    float    from_input[2];  ///< g.
    float    from_output[2]; ///< h; zero where no measurement enters the equations.
} sd_plant_step_t;

#ifdef __cplusplus
}
#endif

#endif
