/* SPDX-License-Identifier: MIT */
/* What the bodies of this folder share. N is set by the including file. */
#ifndef SD_AFR_PARTS_H
#define SD_AFR_PARTS_H
#include "sd_math.h"

#ifdef __cplusplus
extern "C" {
#endif

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define F(name)     JOIN(name, N) /* F(sd_mul) -> sd_mul_f32 */
#define R(name)     JOIN(sd_real_##name, N) /* numbers of any size at init and once a cycle: sd_num.h */
#define REAL        JOIN(F(sd_real), t)

static inline float       sd_real_root_f32(float x)       { return sd_root(x); }
static inline sd_scaled_t sd_real_root_q31(sd_scaled_t x) { return sd_scaled_root(x); }

/* x in [0, 1) cut into equal parts: which one, and how far into it. Of anything else, NaN too, the part after the last. */
static inline uint32_t sd_afr_split_f32(float x, uint32_t parts, float *rest) {
    const float at = x * (float)parts;
    const uint32_t part = ((at >= 0.0f) && (at < (float)parts)) ? (uint32_t)at : parts;
    *rest = at - (float)part;
    return part;
}
static inline uint32_t sd_afr_split_q31(sd_q31_t x, uint32_t parts, sd_q31_t *rest) {
    const uint64_t at = (uint64_t)(uint32_t)x * parts; /* parts is a power of two, and known when this is compiled */
    *rest = (sd_q31_t)((uint32_t)at & 0x7fffffffu);
    return (uint32_t)(at >> 31);
}

/* n / d for 0 <= n < d; in q31 to 15 bits, by the core's own division. */
static inline float sd_afr_over_f32(float n, float d) { return n / d; }
static inline sd_q31_t sd_afr_over_q31(sd_q31_t n, sd_q31_t d) {
    const uint32_t shift = (uint32_t)__builtin_clz((uint32_t)d) - 1u;
    const uint32_t part = ((uint32_t)n << shift) / ((((uint32_t)d << shift) >> 15) + 1u); /* below 2^15 */
    return (sd_q31_t)(part << 16);
}

/* a b + c d, for (a, c) and (b, d) on or within circles of radius sqrt(2) and 1. */
static inline float    sd_afr_dot_f32(float a, float b, float c, float d) { return a * b + c * d; }
static inline sd_q31_t sd_afr_dot_q31(sd_q31_t a, sd_q31_t b, sd_q31_t c, sd_q31_t d) {
    return sd_high_q31((int64_t)a * b + (int64_t)c * d);
}
static inline float    sd_afr_cross_f32(float a, float b, float c, float d) { return a * b - c * d; }
static inline sd_q31_t sd_afr_cross_q31(sd_q31_t a, sd_q31_t b, sd_q31_t c, sd_q31_t d) {
    return sd_high_q31((int64_t)a * b - (int64_t)c * d);
}

#ifdef __cplusplus
}
#endif

#endif
