/* SPDX-License-Identifier: MIT */
#include <stdbool.h>

#include "sd_switched_wheel.h"

/* j w^2/2 over the tooth's period that ends at position k, j its inertia; false where w^2/2 is out of (0, 1). */
static inline bool energy_of(const sd_wheel_tables_t *t, uint32_t k, uint32_t period_ticks, float *energy) {
    const float speed = t->speed_per_tick / (float)period_ticks;
    *energy = speed * speed * sd_from_q31_f32(t->inertia_q31[(k < t->positions) ? k : k - t->positions]);
    return speed < 1.0f;
}

static float index_of(float residual, float lost) {
    return sd_within_f32(1.0f + residual / lost, 10.0f) * (1.0f / (float)(1 << SD_WHEEL_INDEX_BITS));
}

#define N f32
#define T float
#include "sd_switched_wheel.inc"
