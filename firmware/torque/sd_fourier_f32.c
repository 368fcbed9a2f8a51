/* SPDX-License-Identifier: MIT */
#define N f32
#define T float
#include "sd_fourier.h"

/* (c, s) turned by the angle of (cosine, sine). */
static inline void sd_turn_f32(float *c, float *s, float cosine, float sine) {
    const float before = *c;
    *c = before * cosine - *s * sine;
    *s = before * sine + *s * cosine;
}

typedef float sd_series_f32_t;
static inline float sd_series_f32(float x) { return x; }
static inline float sd_series_add_f32(float sum, float c, float f) { return sum + c * f; }
static inline float sd_series_end_f32(float sum) { return sum; }

#include "sd_fourier.inc"

_Static_assert(sizeof(sd_fourier_f32_t) == 160, "without pointers, the same size on every target");

float sd_fourier_gain_limit(const sd_fourier_config_t *config) {
    const float two_per_pitch = (float)config->positions / 3.14159265f; /* 2 / d */
    const float n = (float)config->harmonics;
    return 2.0f / (n * (n + 1.0f)) * (two_per_pitch * (two_per_pitch - config->gain_energy) - config->gain_mean);
}
