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

uint32_t sd_publish_part(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate, uint32_t from) {
    const sd_rate_info_t *row = &sd_rate_infos[rate];
    const uint16_t *channel = &row->channels[from];
    const uint8_t *owner = &row->owners[from];
    const float *values = (const float *)&self->signals;
    const uint32_t left = row->count - from, count = (left < SD_PUBLISH_PART) ? left : SD_PUBLISH_PART;
    union { float value; uint32_t bits; } both;
    sd_event_t events[SD_PUBLISH_PART], *event = events;
    for (uint32_t i = 0; i < count; ++i, ++event) {
        const sd_status_t *status = &self->status[owner[i]];
        both.value = values[channel[i]];
        event->tick = tick;
        event->kind = SD_EVENT_SIGNAL;
        event->channel = channel[i];
        event->value = both.bits;
        event->flags = status->health | ((uint32_t)status->why << 8);
    }
    self->unsent += count - port->send(port->context, events, count);
    return (from + count < row->count) ? from + count : 0u;
}

void sd_publish_row(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate) {
    uint32_t from = 0;
    do { from = sd_publish_part(self, port, tick, rate, from); } while (from != 0u);
}
