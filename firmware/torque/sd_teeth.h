/* SPDX-License-Identifier: MIT */
/* Sums over the teeth of a revolution, missing ones left out. Of sd_pattern and sd_twist. */
#ifndef SD_TEETH_H
#define SD_TEETH_H
#include "sd_kalman.h"

#ifdef __cplusplus
extern "C" {
#endif

static inline float sd_teeth_count(const sd_kalman_tables_t *t) {
    float count = 0.0f;
    for (uint32_t k = 0; k < t->positions; ++k) { count += sd_kalman_has_tooth(t, k) ? 1.0f : 0.0f; }
    return count;
}

static inline float sd_teeth_mean_product(const sd_kalman_tables_t *t, const float *a, const float *b) {
    float sum = 0.0f;
    for (uint32_t k = 0; k < t->positions; ++k) { sum += sd_kalman_has_tooth(t, k) ? a[k] * b[k] : 0.0f; }
    return sum / sd_teeth_count(t);
}

/* Line of least squares: level in the middle, at k = N / 2, and slope a position. */
static inline void sd_teeth_line(const sd_kalman_tables_t *t, const float *values, float *level, float *slope) {
    const float count = sd_teeth_count(t);
    float k_sum = 0.0f, v_sum = 0.0f, kk = 0.0f, kv = 0.0f;
    for (uint32_t k = 0; k < t->positions; ++k) {
        if (!sd_kalman_has_tooth(t, k)) { continue; }
        const float at = (float)k - 0.5f * (float)t->positions;
        k_sum += at; v_sum += values[k]; kk += at * at; kv += at * values[k];
    }
    *slope = (count * kv - k_sum * v_sum) / (count * kk - k_sum * k_sum);
    *level = (v_sum - *slope * k_sum) / count;
}

#ifdef __cplusplus
}
#endif

#endif
