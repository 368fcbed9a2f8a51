/* SPDX-License-Identifier: MIT */
#define N q31
#define T sd_q31_t
#include "sd_afr_parts.h"
#include "sd_afr_point.h"

/* Weights of 16 bits that add up to 2^16, so that no sum of products leaves 32 bits. */
#define WEIGHT uint32_t
static void weights(const sd_q31_t *weight, uint32_t *w) {
    w[7] = 1u << 16;
    for (uint32_t i = 0; i < 7u; ++i) {
        w[i] = (uint32_t)weight[i] >> 15;
        w[7] -= w[i];
    }
}
static inline sd_q31_t mixed(const sd_afr_node_t *const *of, const uint32_t *w, uint32_t n) {
    const uint32_t sum = w[0] * of[0]->share[n] + w[1] * of[1]->share[n] + w[2] * of[2]->share[n] + w[3] * of[3]->share[n] +
                         w[4] * of[4]->share[n] + w[5] * of[5]->share[n] + w[6] * of[6]->share[n] + w[7] * of[7]->share[n];
    return (sd_q31_t)(sum >> 1);
}
#include "sd_afr_point.inc"
