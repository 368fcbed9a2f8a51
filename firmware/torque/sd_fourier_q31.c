/* SPDX-License-Identifier: MIT */
#define N q31
#define T sd_q31_t
#include "sd_fourier.h"

/* (c, s) turned by the angle of (cosine, sine). */
static inline void sd_turn_q31(sd_q31_t *c, sd_q31_t *s, sd_q31_t cosine, sd_q31_t sine) {
    const int64_t before = *c, other = *s;
    *c = sd_high_q31(before * cosine - other * sine);
    *s = sd_high_q31(before * sine + other * cosine);
}

/* The sum has 27 bits behind the point and 36 before it, so that no 25 products overflow: sines give up their last 4 bits. */
typedef int64_t sd_series_q31_t;
static inline int64_t  sd_series_q31(sd_q31_t x) { return (int64_t)x * ((int64_t)1 << 27); }
static inline int64_t  sd_series_add_q31(int64_t sum, sd_q31_t c, sd_q31_t f) { return sum + (int64_t)c * (f >> 4); }
static inline sd_q31_t sd_series_end_q31(int64_t sum) { return sd_sat_q31(sum >> 27); }

#include "sd_fourier.inc"

_Static_assert(sizeof(sd_fourier_q31_t) == 176, "without pointers, the same size on every target");
