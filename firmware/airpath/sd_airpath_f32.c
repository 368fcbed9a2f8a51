/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "sd_airpath_bank.h"

#define N f32
#define T float
#define NUMBER_MAX    1e6f
#define EMPTYING_MOST 1000.0f
#define AREA_MOST     1e5f
#define PERIOD_MOST   0.1f
#define FAULT_MOST    1e4f
#include "sd_parts.inc"

_Static_assert(sizeof(sd_airpath_bank_f32_t) == 160, "without pointers, the same size on every target");

bool sd_nuio_table_ok_f32(const sd_nuio_table_f32_t *o) {
    return sd_all_within(&o->m[0][0], sizeof *o / sizeof(float), -NUMBER_MAX, NUMBER_MAX); /* floats alone, without gaps */
}

static bool weights_ok(const float *weight, float offset) {
    return sd_all_within(weight, SD_CUSUM_RESIDUALS_MAX, -NUMBER_MAX, NUMBER_MAX) && (offset <= NUMBER_MAX);
}

/* Which interval of `steps` equal ones over [0, 1] holds the share, and how far into it: of what is no number, no number into the first. */
static inline uint32_t split(float share, uint32_t steps, float *rest) {
    const float at = share * (float)steps;
    const uint32_t i = ((at > 0.0f) && (at < (float)steps)) ? (uint32_t)at : (at > 0.0f) ? steps - 1u : 0u;
    *rest = at - (float)i;
    return i;
}

static float mean_over(float sum, float flow_sum) { return sum / flow_sum; }

static inline bool lasted(uint32_t steps, float period_s, float seconds) { return (float)steps * period_s >= seconds; }

static bool sound(const sd_nuio_f32_t *observer, float residual) {
    (void)observer;
    return sd_within(residual, -NUMBER_MAX, NUMBER_MAX);
}

#include "sd_nuio.inc"

#include "sd_cusum.inc"

#include "sd_airpath_flows.inc"

#include "sd_airpath_offsets.inc"

#include "sd_airpath_point.inc"

#include "sd_airpath_bank.inc"
