/* SPDX-License-Identifier: MIT */
#include "sd_publish.h"

#include <string.h>

_Static_assert(sizeof(sd_signals_t) == SD_SIGNAL_COUNT * sizeof(float), "signals are floats, without gaps");

void sd_publish_init(sd_publish_t *self) {
    const sd_status_t unknown = { .health = SD_INVALID, .why = SD_WHY_NO_SYNC };
    memset(self, 0, sizeof *self);
    for (uint32_t owner = 0; owner < SD_OWNER_COUNT; ++owner) { sd_publish_judge(self, (sd_owner_t)owner, &unknown); }
}

/* flags: of all owners. */
static uint32_t fill(const sd_publish_t *self, const sd_rate_info_t *row, uint32_t from, uint32_t tick, const uint32_t *flags,
                     sd_event_t *event) {
    const uint16_t *channel = &row->channels[from];
    const uint8_t *owner = &row->owners[from];
    const float *values = (const float *)&self->signals;
    const uint32_t rest = row->count - from, count = (rest < SD_PUBLISH_PART) ? rest : SD_PUBLISH_PART;
    union { float value; uint32_t bits; } both;
    uint32_t left = count;
    do { /* a row has at least one signal */
        const uint16_t at = *channel++;
        both.value = values[at];
        *event++ = (sd_event_t){ .tick = tick, .kind = SD_EVENT_SIGNAL, .channel = at, .value = both.bits, .flags = flags[*owner++] };
    } while (--left > 0u);
    return count;
}

uint32_t sd_publish_part(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate, uint32_t from) {
    const sd_rate_info_t *row = &sd_rate_infos[rate];
    sd_event_t events[SD_PUBLISH_PART];
    const bool in_parts = row->count > SD_PUBLISH_PART;
    if (in_parts && (from == 0u)) { memcpy(self->row_flags, self->flags, sizeof self->row_flags); }
    const uint32_t count = fill(self, row, from, tick, in_parts ? self->row_flags : self->flags, events);
    self->unsent += count - port->send(port->context, events, count);
    return (from + count < row->count) ? from + count : 0u;
}

void sd_publish_row(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate) {
    uint32_t from = 0;
    do { from = sd_publish_part(self, port, tick, rate, from); } while (from != 0u);
}
