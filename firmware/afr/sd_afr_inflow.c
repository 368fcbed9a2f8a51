/* SPDX-License-Identifier: MIT */
#include "sd_afr_inflow.h"

void sd_afr_inflow_of(const sd_exhaust_now_f32_t *now, sd_afr_inflow_t *out) {
    const uint32_t count = now->count;
    const float charge = now->charge;
    float mass = now->mass; /* after the position: before it, without what flowed in */
    for (uint32_t k = 0; k < count; ++k) { mass -= charge * now->share[now->flowing[k]]; }
    if (!(mass > 0.0f)) { mass = 0.0f; }
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t i = now->flowing[k];
        const float added = charge * now->share[i];
        mass += added;
        out->cylinder[k] = (uint8_t)i;
        out->share[k] = added / mass;
    }
    out->count = (uint8_t)count;
}
