/* SPDX-License-Identifier: MIT */
#include "sd_punctual.h"

#include <stdbool.h>

#define PERIOD_MAX 0x10000000u /* ticks; longer ones are no turning */

uint32_t sd_punctual_period(sd_punctual_t *self, uint32_t period_ticks, uint32_t advance, float late_rad, float positions_per_rad) {
    const float late = late_rad * positions_per_rad, left = self->left_ticks;
    const bool turns = (period_ticks > 0u) && (period_ticks < PERIOD_MAX) && (late > -0.5f) && (late < 0.5f);
    const int32_t before = self->late_ticks;
    self->late_ticks = 0;
    self->left_ticks = 0.0f;
    if (!turns) { return period_ticks; }
    const int32_t since = (int32_t)period_ticks + before; /* from the last tooth's place, `advance` + `late` positions */
    const float ticks = late * (float)since / ((float)advance + late) + left;
    self->late_ticks = (int32_t)((ticks < 0.0f) ? ticks - 0.5f : ticks + 0.5f);
    self->left_ticks = ticks - (float)self->late_ticks;
    const int32_t even = since - self->late_ticks;
    return (even > 0) ? (uint32_t)even : 1u;
}
