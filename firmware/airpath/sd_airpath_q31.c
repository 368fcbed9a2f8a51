/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "sd_airpath_bank.h"

#define N q31
#define T sd_q31_t
#define EMPTYING_MOST ONE
#define AREA_MOST     CONSTANT(12800.0f, SD_AIRPATH_AREA) /* at 200 K and 200 J/(kg K) a flow of 64 g/(s kPa) still */
#define PERIOD_MOST   ONE
#define FAULT_MOST    ONE
#include "sd_parts.inc"

_Static_assert(sizeof(sd_airpath_bank_q31_t) == 176, "without pointers, the same size on every target");

bool sd_nuio_table_ok_q31(const sd_nuio_table_q31_t *o) {
    bool ok = sd_wide_fits_q31(o->gamma, SD_NUIO_OUTPUTS);
    for (uint32_t i = 0; ok && (i < (uint32_t)SD_NUIO_STATES); ++i) {
        const sd_q31_t k[2 * SD_NUIO_OUTPUTS] = { o->k[i][0], o->k[i][1], o->more[i][0], o->more[i][1] };
        ok = sd_wide_fits_q31(o->m[i], SD_NUIO_STATES) && sd_wide_fits_q31(o->e[i], SD_NUIO_OUTPUTS) &&
             sd_wide_fits_q31(k, 2 * SD_NUIO_OUTPUTS);
    }
    return ok;
}

static bool weights_ok(const sd_q31_t *weight, sd_q31_t offset) {
    (void)offset;
    return sd_wide_fits_q31(weight, SD_CUSUM_RESIDUALS_MAX);
}

/* Which interval of `steps` equal ones over [0, 1) holds the share, and how far into it. */
static inline uint32_t split(sd_q31_t share, uint32_t steps, sd_q31_t *rest) {
    const uint64_t at = (uint64_t)(uint32_t)share * steps;
    *rest = (sd_q31_t)((uint32_t)at & 0x7fffffffu);
    return (uint32_t)(at >> 31);
}

/* Per unit of 16 kPa s/g, of sums of residuals and of flows: both as far down as it takes to hold them in 32 bits. */
static sd_q31_t mean_over(int64_t sum, int64_t flow_sum) {
    int64_t n = sum, d = flow_sum;
    while ((d > INT32_MAX) || (n > INT32_MAX) || (n < INT32_MIN)) {
        d >>= 1;
        n >>= 1;
    }
    return sd_over_q31((sd_q31_t)n, (sd_q31_t)d, 10);
}

/* To half a period. */
static inline bool lasted(uint32_t steps, sd_q31_t period, float seconds) {
    return (uint64_t)steps * (uint32_t)period + (uint32_t)period / 2u >= (uint64_t)((double)seconds * 137438953472.0); /* 2^37 */
}

/* A number that has come to the end of its range is not what it should be. */
static bool sound(const sd_nuio_q31_t *observer, sd_q31_t residual) {
    sd_q31_t largest = residual ^ (residual >> 31); /* both ends of the range give the larger one */
    for (uint32_t i = 0; i < (uint32_t)SD_NUIO_STATES; ++i) {
        const sd_q31_t size = observer->z[i] ^ (observer->z[i] >> 31);
        largest = (size > largest) ? size : largest;
    }
    return largest < INT32_MAX;
}

#include "sd_nuio.inc"

#include "sd_cusum.inc"

#include "sd_airpath_flows.inc"

#include "sd_airpath_offsets.inc"

#include "sd_airpath_point.inc"

#include "sd_airpath_bank.inc"
