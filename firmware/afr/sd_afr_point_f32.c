/* SPDX-License-Identifier: MIT */
#define N f32
#define T float
#include "sd_afr_parts.h"
#include "sd_afr_point.h"

#define WEIGHT float
static void weights(const float *weight, float *w) {
    for (uint32_t i = 0; i < 8u; ++i) { w[i] = weight[i]; }
}
/* Written out: a loop over the corners would cost twice as much. */
static inline float mixed(const sd_afr_node_t *const *of, const float *w, uint32_t n) {
    const float sum = w[0] * (float)of[0]->share[n] + w[1] * (float)of[1]->share[n] + w[2] * (float)of[2]->share[n] +
                      w[3] * (float)of[3]->share[n] + w[4] * (float)of[4]->share[n] + w[5] * (float)of[5]->share[n] +
                      w[6] * (float)of[6]->share[n] + w[7] * (float)of[7]->share[n];
    return sum * (1.0f / 65536.0f);
}
#include "sd_afr_point.inc"
