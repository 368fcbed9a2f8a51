/* SPDX-License-Identifier: MIT */
#include "sd_road.h"

#define NOISE_FACTOR 3.5f
#define TORQUE_SHARE 0.04f /* of the mean torque: what a pulse that burns otherwise leaves */
#define MOST         4.0f  /* that one firing counts */
#define MEMORY       32.0f /* firings */
#define ROUGH_FROM   1.0f
#define SMOOTH_BELOW 0.5f

_Static_assert(sizeof(sd_road_t) == 40, "without pointers, the same size on every target");

void sd_road_restart(sd_road_t *self) { self->seen = 0; }

static float square(float x) { return x * x; }

bool sd_road_step(sd_road_t *self, const sd_firing_t *smooth, const sd_firing_t *rough) {
    const uint32_t i = smooth->index;
    const float difference = smooth->torque_nm - rough->torque_nm;
    const float limit = square(NOISE_FACTOR * rough->noise_nm) + square(TORQUE_SHARE * rough->mean_nm);
    const bool usable = (i < SD_KALMAN_FIRINGS_MAX) && (rough->index == i) && (difference > -1e6f) && (difference < 1e6f) &&
                        (limit > 0.0f) && (limit < 1e12f);
    if (!usable) { return self->rough != 0u; }
    if ((self->seen & (1u << i)) != 0u) {
        const float change = square(difference - self->difference_nm[i]);
        const float size = (change < MOST * limit) ? change / limit : MOST;
        self->evidence += (size - self->evidence) / MEMORY;
    }
    self->difference_nm[i] = difference;
    self->seen = (uint8_t)(self->seen | (1u << i));
    if (self->evidence >= ROUGH_FROM) { self->rough = 1; }
    if (self->evidence < SMOOTH_BELOW) { self->rough = 0; }
    return self->rough != 0u;
}
