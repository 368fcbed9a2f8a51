/* SPDX-License-Identifier: MIT */
/* What the bodies of this folder share. N is set by the including file. */
#ifndef SD_AFR_PARTS_H
#define SD_AFR_PARTS_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define F(name)     JOIN(name, N) /* F(sd_mul) -> sd_mul_f32 */

/* x in [0, 1) cut into equal parts: which one, and how far into it. */
static inline uint32_t sd_afr_split_f32(float x, uint32_t parts, float *rest) {
    const float at = x * (float)parts;
    const uint32_t part = (uint32_t)at;
    *rest = at - (float)part;
    return part;
}
static inline uint32_t sd_afr_split_q31(sd_q31_t x, uint32_t parts, sd_q31_t *rest) {
    const int64_t at = (int64_t)x * parts;
    *rest = (sd_q31_t)(at & 0x7fffffff);
    return (uint32_t)(at >> 31);
}

/* n / d for 0 <= n < d. */
static inline float sd_afr_over_f32(float n, float d) { return n / d; }
static inline sd_q31_t sd_afr_over_q31(sd_q31_t n, sd_q31_t d) { return (sd_q31_t)(((int64_t)n << 31) / d); }

#ifdef __cplusplus
}
#endif

#endif
