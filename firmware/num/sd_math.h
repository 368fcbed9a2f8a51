/* SPDX-License-Identifier: MIT */
/// sd_math.h - the small mathematics that every block uses, in float, without libm and with the same bits on every target.
#ifndef SD_MATH_H
#define SD_MATH_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_PI            3.14159265f  ///< Pi.
#define SD_TWO_PI        6.2831853f   ///< Two pi.
#define SD_RAD_PER_DEG   0.017453293f ///< Radians in a degree.
#define SD_RADPS_PER_RPM 0.10471976f  ///< rad/s in a revolution a minute.
#define SD_RPM_PER_RADPS 9.5492966f   ///< Revolutions a minute in a rad/s.

/// True for low <= x <= high, false for NaN.
static inline bool sd_within(float x, float low, float high) { return (x >= low) && (x <= high); }
/// True for above < x <= to, false for NaN.
static inline bool sd_above_to(float x, float above, float to) { return (x > above) && (x <= to); }
/// sd_within of each of `count` values.
static inline bool sd_all_within(const float *x, uint32_t count, float low, float high) {
    bool ok = true;
    for (uint32_t i = 0; ok && (i < count); ++i) { ok = sd_within(x[i], low, high); }
    return ok;
}
/// x cut to [low, high]; NaN stays NaN.
static inline float sd_clamp(float x, float low, float high) { return (x < low) ? low : (x > high) ? high : x; }
/// Square root, rounded once; 0 for anything that is not above 1e-30 (negative numbers and NaN too).
static inline float sd_root(float x) { return (x > 1e-30f) ? sd_sqrt_f32(x) : 0.0f; }
/// 1 - exp(-x) for x >= 0: what a first-order lag moves by in x of its time constants. The Pade approximant of order (2, 2),
/// whose denominator cannot vanish; 5.4e-4 too small at x = 1.
static inline float sd_lag_move(float x) { return x / (1.0f + 0.5f * x + x * x * (1.0f / 12.0f)); }

#ifdef __cplusplus
}
#endif

#endif
