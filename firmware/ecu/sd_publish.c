/* SPDX-License-Identifier: MIT */
#include "sd_publish.h"

#include <stddef.h>
#include <string.h>

_Static_assert(sizeof(sd_signals_t) == SD_SIGNAL_COUNT * sizeof(float), "signals are floats, without gaps");

void sd_publish_init(sd_publish_t *self) {
    memset(self, 0, sizeof *self);
    for (uint32_t owner = 0; owner < SD_OWNER_COUNT; ++owner) {
        self->status[owner] = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_NO_SYNC };
    }
}

static uint32_t flags_of(const sd_status_t *status) { return status->health | ((uint32_t)status->why << 8); }

static void freeze_health(sd_publish_t *self) {
    for (uint32_t owner = 0; owner < SD_OWNER_COUNT; ++owner) { self->row_flags[owner] = flags_of(&self->status[owner]); }
}

/* frozen: health of a row that leaves in several parts; NULL: health as it is now. Called with a constant, it is two loops. */
static inline uint32_t fill(const sd_publish_t *self, const sd_rate_info_t *row, uint32_t from, uint32_t tick, const uint32_t *frozen,
                            sd_event_t *event) {
    const uint16_t *channel = &row->channels[from];
    const uint8_t *owner = &row->owners[from];
    const float *values = (const float *)&self->signals;
    const uint32_t left = row->count - from, count = (left < SD_PUBLISH_PART) ? left : SD_PUBLISH_PART;
    union { float value; uint32_t bits; } both;
    uint32_t i = 0;
    do { /* a row has at least one signal */
        both.value = values[channel[i]];
        const uint32_t flags = (frozen != NULL) ? frozen[owner[i]] : flags_of(&self->status[owner[i]]);
        event[i] = (sd_event_t){ .tick = tick, .kind = SD_EVENT_SIGNAL, .channel = channel[i], .value = both.bits, .flags = flags };
    } while (++i < count);
    return count;
}

uint32_t sd_publish_part(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate, uint32_t from) {
    const sd_rate_info_t *row = &sd_rate_infos[rate];
    sd_event_t events[SD_PUBLISH_PART];
    uint32_t count;
    if (row->count > SD_PUBLISH_PART) {
        if (from == 0u) { freeze_health(self); }
        count = fill(self, row, from, tick, self->row_flags, events);
    } else {
        count = fill(self, row, from, tick, NULL, events);
    }
    self->unsent += count - port->send(port->context, events, count);
    return (from + count < row->count) ? from + count : 0u;
}

void sd_publish_row(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate) {
    uint32_t from = 0;
    do { from = sd_publish_part(self, port, tick, rate, from); } while (from != 0u);
}
