/* SPDX-License-Identifier: MIT */
#include <stdbool.h>

#include "sd_switched_wheel.h"

/* j w^2/2 over the tooth's period that ends at position k, j its inertia; false where w^2/2 is out of (0, 1). One division of
 * 32 bits: what it rounds off is below the timer's own error. */
static inline bool energy_of(const sd_wheel_tables_t *t, uint32_t k, uint32_t period_ticks, sd_q31_t *energy) {
    const uint32_t share = (period_ticks > 0u) ? t->speed_numerator / period_ticks : UINT32_MAX;
    if (share >= (0x80000000u >> t->speed_shift)) { return false; }
    const sd_q31_t speed = (sd_q31_t)(share << t->speed_shift);
    *energy = sd_mul_q31(sd_mul_q31(speed, speed), t->inertia_q31[(k < t->positions) ? k : k - t->positions]);
    return true;
}

/* (1 + residual / lost) / 16, within 10 / 16. */
static sd_q31_t index_of(sd_q31_t residual, sd_q31_t lost) {
    const sd_q31_t one = 1 << (31 - SD_WHEEL_INDEX_BITS);
    const uint64_t share = ((uint64_t)sd_abs_q31(residual) << (31 - SD_WHEEL_INDEX_BITS)) / (uint32_t)((lost > 0) ? lost : 1);
    const sd_q31_t size = (share < (uint64_t)(10 * one)) ? (sd_q31_t)share : 10 * one;
    return sd_within_q31(sd_add_q31(one, (residual < 0) ? -size : size), 10 * one);
}

#define N q31
#define T sd_q31_t
#include "sd_switched_wheel.inc"
