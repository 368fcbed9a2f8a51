/* SPDX-License-Identifier: MIT */
#define N f32
#define T float
#include "sd_fourier.inc"

_Static_assert(sizeof(sd_fourier_f32_t) == 204, "without pointers, the same size on every target");

float sd_fourier_gain_limit(const sd_fourier_config_t *config) {
    const float two_per_pitch = (float)config->positions / 3.14159265f; /* 2 / d */
    const float n = (float)config->harmonics;
    return 2.0f / (n * (n + 1.0f)) * (two_per_pitch * (two_per_pitch - config->gain_energy) - config->gain_mean);
}
