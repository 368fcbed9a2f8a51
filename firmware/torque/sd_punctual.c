/* SPDX-License-Identifier: MIT */
#include "sd_punctual.h"

#include <stdbool.h>

#define PERIOD_MAX 0x10000000u /* ticks; longer ones are no turning */

uint32_t sd_punctual_period(sd_punctual_t *self, uint32_t period_ticks, uint32_t advance, float late_rad, float positions_per_rad) {
    const float late = late_rad * positions_per_rad, left = self->left_ticks;
    const bool regular = (period_ticks < PERIOD_MAX) && (advance > 0u) && (late > -0.5f) && (late < 0.5f);
    /* From the last tooth's place, `advance` + `late` positions. Below 1: no wheel turns so, and the times begin anew. */
    const int32_t since = regular ? (int32_t)period_ticks + self->late_ticks : 0;
    self->late_ticks = 0;
    self->left_ticks = 0.0f;
    if ((period_ticks == 0u) || (since < 1)) { return period_ticks; }
    const float ticks = late * (float)since / ((float)advance + late) + left;
    self->late_ticks = (int32_t)((ticks < 0.0f) ? ticks - 0.5f : ticks + 0.5f);
    self->left_ticks = ticks - (float)self->late_ticks;
    const int32_t even = since - self->late_ticks;
    return (even > 0) ? (uint32_t)even : 1u;
}
