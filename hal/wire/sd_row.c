/* SPDX-License-Identifier: MIT */
#include "sd_row.h"

enum { STALE_IN_ROW_MAX = 8 }; /* then the sender has started anew with the session of before */

void sd_queue_put(sd_queue_t *queue, const sd_event_t *event) {
    if (queue->written - queue->read >= SD_QUEUE_EVENTS) { queue->overrun++; return; }
    queue->events[queue->written++ % SD_QUEUE_EVENTS] = *event;
}

uint32_t sd_queue_take(sd_queue_t *queue, sd_event_t *events, uint32_t room) {
    uint32_t count = 0;
    while ((count < room) && (queue->read != queue->written)) {
        events[count++] = queue->events[queue->read++ % SD_QUEUE_EVENTS];
    }
    return count;
}

const sd_row_t *sd_row_take(sd_row_t rows[SD_RATE_COUNT], const sd_event_t *event) {
    if (event->channel >= SD_SIGNAL_COUNT) { return NULL; }
    const sd_signal_info_t *info = &sd_signal_infos[event->channel];
    sd_row_t *row = &rows[info->rate];
    if ((row->left == 0u) || (event->tick != row->tick) || (row->present[event->channel] != 0u)) {
        sd_row_begin(row, event->tick, info->rate);
    }
    float value;
    memcpy(&value, &event->value, sizeof value);
    sd_row_put(row, event->channel, value);
    sd_row_status(row, info->owner, (uint8_t)(event->flags & 0xffu), (uint16_t)(event->flags >> 8));
    return (row->left == 0u) ? row : NULL;
}

int sd_row_events(const sd_row_t *row, sd_queue_t *queue) {
    for (uint32_t c = 0; c < SD_SIGNAL_COUNT; ++c) {
        const float difference = row->value[c] - row->value[c]; /* 0 for finite numbers only */
        if (!(difference == 0.0f) || (row->health[sd_signal_infos[c].owner] > 2u)) { return 0; }
    }
    for (uint32_t c = 0; c < SD_SIGNAL_COUNT; ++c) {
        if (row->present[c] == 0u) { continue; }
        const uint8_t owner = sd_signal_infos[c].owner;
        sd_event_t event = { .tick = row->tick, .kind = SD_EVENT_SIGNAL, .channel = (uint16_t)c,
                             .flags = row->health[owner] | ((uint32_t)row->why[owner] << 8) };
        memcpy(&event.value, &row->value[c], sizeof event.value);
        sd_queue_put(queue, &event);
    }
    return 1;
}

sd_arrival_t sd_order_check(sd_order_t *order, uint16_t session, uint16_t sequence, uint16_t step) {
    const uint16_t ahead = (uint16_t)(sequence - order->next);
    const int same = (order->started != 0u) && (session == order->session);
    if (same && (ahead >= 0x8000u) && (order->stale_in_row < STALE_IN_ROW_MAX)) {
        order->stale_in_row++;
        return SD_ARRIVAL_STALE;
    }
    const sd_arrival_t arrival = ((order->started == 0u) || (same && (ahead == 0u))) ? SD_ARRIVAL_NEXT : SD_ARRIVAL_GAP;
    const uint32_t anew = ((order->started != 0u) && (session != order->session)) ? 1u : 0u;
    *order = (sd_order_t){ .next = (uint16_t)(sequence + step), .session = session, .started = 1, .starts = order->starts + anew };
    return arrival;
}
