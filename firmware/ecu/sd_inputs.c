/* SPDX-License-Identifier: MIT */
#include "sd_inputs.h"

#include <stddef.h>

#include "sd_value.h"

_Static_assert(SD_INPUT_COUNT <= 32u, "a bit for each input");

bool sd_inputs_take(sd_inputs_t *self, uint16_t channel, uint32_t tick, float value) {
    const sd_input_info_t *info = (channel < SD_INPUT_COUNT) ? &sd_input_infos[channel] : NULL;
    if ((info == NULL) || !sd_bits_within(value, info->low, info->high)) { /* NaN is out of range */
        self->rejected++;
        return false;
    }
    self->reading[channel] = (sd_reading_t){ .value = value, .tick = tick };
    self->seen |= 1u << channel;
    self->fresh |= 1u << channel;
    return true;
}

void sd_inputs_age(sd_inputs_t *self, uint32_t tick, float tick_hz) {
    for (uint32_t i = 0; i < SD_INPUT_COUNT; ++i) {
        /* A reading that was taken after `tick` has no age yet. Once too old, it stays so until the next one: the difference of
         * ticks wraps. */
        const int32_t age_ticks = (int32_t)(tick - self->reading[i].tick);
        const float limit_s = sd_input_infos[i].age_s; /* 0: for ever */
        const bool ages = sd_bits_order(limit_s) > 0;
        if (ages && V(less)(V(mul)(V(of)(limit_s), V(of)(tick_hz)), V(int)(age_ticks))) { self->fresh &= ~(1u << i); }
    }
}

void sd_inputs_judge(const sd_inputs_t *self, sd_owner_t owner, sd_status_t *status) {
    const sd_owner_info_t *info = &sd_owner_infos[owner];
    const uint32_t needed = info->degraded_without | info->invalid_without, lacking = needed & ~self->fresh;
    if (lacking == 0u) { return; }
    const uint8_t health = ((lacking & info->invalid_without) != 0u) ? (uint8_t)SD_INVALID : (uint8_t)SD_DEGRADED;
    if ((lacking & ~self->seen) != 0u) { sd_status_worst_of(status, health, SD_WHY_NO_INPUT); }
    if ((lacking & self->seen) != 0u) { sd_status_worst_of(status, health, SD_WHY_STALE_INPUT); }
}
