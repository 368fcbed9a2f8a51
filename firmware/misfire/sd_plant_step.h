/* SPDX-License-Identifier: MIT */
/// sd_plant_step.h - one exact step of the crank of document 000, computed on the host, for one length of the step.
///
///   v1' = v2,  v2' = -k2 v2 - k1 v1 + C Q          v1: crank pin speed less its mean, m/s; C Q: input, m/s^3
///
/// With the input's mean over the step it is x+ = x + D x + g u, D = exp(A T) - I. D and g come from the host: no exponential
/// is needed on a target, and a D near zero keeps its digits.
#ifndef SD_PLANT_STEP_H
#define SD_PLANT_STEP_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// SI units.
typedef struct sd_plant_step {
    float increment[2][2]; ///< D; finite, like all below.
    float from_input[2];   ///< g.
} sd_plant_step_t;

#ifdef __cplusplus
}
#endif

#endif
