/* SPDX-License-Identifier: MIT */
#include "sd_publish.h"

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

uint32_t sd_publish_part(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate, uint32_t from) {
    const sd_rate_info_t *row = &sd_rate_infos[rate];
    const uint16_t *channel = &row->channels[from];
    const uint8_t *owner = &row->owners[from];
    const float *values = (const float *)&self->signals;
    const uint32_t left = row->count - from, count = (left < SD_PUBLISH_PART) ? left : SD_PUBLISH_PART;
    const bool several = row->count > SD_PUBLISH_PART;
    union { float value; uint32_t bits; } both;
    sd_event_t events[SD_PUBLISH_PART], *event = events;
    if (several && (from == 0u)) { freeze_health(self); }
    for (uint32_t i = 0; i < count; ++i, ++event) {
        both.value = values[channel[i]];
        event->tick = tick;
        event->kind = SD_EVENT_SIGNAL;
        event->channel = channel[i];
        event->value = both.bits;
        event->flags = several ? self->row_flags[owner[i]] : flags_of(&self->status[owner[i]]);
    }
    self->unsent += count - port->send(port->context, events, count);
    return (from + count < row->count) ? from + count : 0u;
}

void sd_publish_row(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate) {
    uint32_t from = 0;
    do { from = sd_publish_part(self, port, tick, rate, from); } while (from != 0u);
}
