/* SPDX-License-Identifier: MIT */
#include "sd_airpath_offsets.h"

#include <string.h>

#define RESIDUALS ((uint32_t)SD_AIRPATH_RESIDUALS)

void sd_airpath_offsets_start(sd_airpath_offsets_t *self) { memset(self, 0, sizeof *self); }

void sd_airpath_offsets_drop(sd_airpath_offsets_t *self) {
    memset(self->sum, 0, sizeof self->sum);
    self->flow_sum = 0.0f;
    self->steps = 0;
}

bool sd_airpath_offsets_step(sd_airpath_offsets_t *self, uint32_t window_steps, const float *residual, float flow_gps) {
    for (uint32_t i = 0; i < RESIDUALS; ++i) { self->sum[i] += residual[i]; }
    self->flow_sum += flow_gps;
    if (++self->steps < window_steps) { return false; }
    for (uint32_t i = 0; i < RESIDUALS; ++i) { self->per_flow[i] = self->sum[i] / self->flow_sum; }
    self->learned = 1;
    sd_airpath_offsets_drop(self);
    return true;
}

void sd_airpath_offsets_take(const sd_airpath_offsets_t *self, const float *residual, float flow_gps, float *out) {
    for (uint32_t i = 0; i < RESIDUALS; ++i) { out[i] = residual[i] - self->per_flow[i] * flow_gps; }
}
