/* SPDX-License-Identifier: MIT */
/// sd_value.h - numbers of any size in code that both kinds of ecu are built from: V(mul)(a, b) and the other verbs of sd_num.h are
/// floating point in the usual build, and scaled integers (sd_scaled.h) in an ecu of fixed point (SD_ECU_FIXED).
#ifndef SD_VALUE_H
#define SD_VALUE_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifdef SD_ECU_FIXED
#define V(verb) sd_real_##verb##_q31
typedef sd_real_q31_t sd_value_t; ///< A number that init works with.
#else
#define V(verb) sd_real_##verb##_f32
typedef sd_real_f32_t sd_value_t; ///< A number that init works with.
#endif

#ifdef __cplusplus
}
#endif

#endif
