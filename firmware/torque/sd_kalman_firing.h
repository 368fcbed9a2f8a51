/* SPDX-License-Identifier: MIT */
/// sd_kalman_firing.h - what the files of the filter on tooth times share; no part of its interface.
#ifndef SD_KALMAN_FIRING_H
#define SD_KALMAN_FIRING_H
#include "sd_kalman.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Where a speed lies among the gain tables of a set: between `at` and the next one, `share` of the way.
typedef struct sd_between {
    uint32_t at, next; ///< Indices of the two tables.
    float    share;    ///< [0, 1].
} sd_between_t;

/// Place of `speed`, rad/s, among the tables of a set.
static inline sd_between_t sd_kalman_between(const sd_kalman_tables_t *t, uint32_t set, float speed) {
    const float *above = t->speed_radps + 1;
    uint32_t at = 0;
    while ((at + 1u < t->speeds) && (speed >= *above)) { at++; above++; }
    sd_between_t b = { at, at, 0.0f };
    if ((at + 1u < t->speeds) && (speed > above[-1])) {
        b.next = at + 1u;
        b.share = (speed - above[-1]) / (above[0] - above[-1]);
    }
    b.at += set * t->speeds;
    b.next += set * t->speeds;
    return b;
}

/// A table's number there, in the table's unit.
static inline float sd_kalman_blend(const float *table, sd_between_t b) { return table[b.at] + b.share * (table[b.next] - table[b.at]); }

/// Sum of all firings' torques, N m.
static inline float sd_kalman_sum_firings(const sd_kalman_filter_t *f, const sd_kalman_tables_t *t) {
    float sum = 0.0f;
    _Pragma("GCC unroll 4")
    for (uint32_t j = 1; j <= t->firings; ++j) { sum += f->motion.coefficient_nm[j]; }
    return sum;
}

/// Fills *firing with firing i < firings, at a tooth, as filter `which` has it now, and keeps it for the mean.
void sd_kalman_read_firing(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, uint32_t i,
                           const sd_kalman_tooth_t *tooth, sd_firing_t *firing);

#ifdef __cplusplus
}
#endif

#endif
