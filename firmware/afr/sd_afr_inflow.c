/* SPDX-License-Identifier: MIT */
#include "sd_afr_inflow.h"

void sd_afr_inflow_of(const sd_exhaust_now_f32_t *now, sd_afr_inflow_t *out) {
    const uint32_t count = now->count;
    const float charge = now->charge;
    float sum = 0.0f;
    out->count = 0;
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t i = now->flowing[k];
        const float added = charge * now->share[i];
        sum += added;
        out->cylinder[k] = (uint8_t)i;
        out->added[k] = added;
    }
    if (!(sum > 0.0f)) { return; }
    const float before = (now->mass > sum) ? now->mass - sum : 0.0f;
    const float per_mass = 1.0f / (before + sum);
    out->per_mass = per_mass;
    out->kept = before * per_mass;
    out->count = (uint8_t)count;
}
