/* SPDX-License-Identifier: MIT */
#include "sd_inproc.h"

static uint32_t take(sd_inproc_ring_t *ring, sd_event_t *events, uint32_t room) {
    uint32_t count = 0;
    while ((count < room) && (ring->read != ring->written)) {
        events[count++] = ring->events[ring->read++ % SD_INPROC_EVENTS];
    }
    return count;
}

static uint32_t put(sd_inproc_t *self, sd_inproc_ring_t *ring, const sd_event_t *events, uint32_t count) {
    uint32_t taken = 0;
    while ((taken < count) && (ring->written - ring->read < SD_INPROC_EVENTS)) {
        ring->events[ring->written++ % SD_INPROC_EVENTS] = events[taken++];
    }
    self->dropped += count - taken;
    return taken;
}

static uint32_t ecu_receive(void *context, sd_event_t *events, uint32_t room) {
    return take(&((sd_inproc_t *)context)->to_ecu, events, room);
}
static uint32_t ecu_send(void *context, const sd_event_t *events, uint32_t count) {
    return put(context, &((sd_inproc_t *)context)->to_host, events, count);
}
static uint32_t host_receive(void *context, sd_event_t *events, uint32_t room) {
    return take(&((sd_inproc_t *)context)->to_host, events, room);
}
static uint32_t host_send(void *context, const sd_event_t *events, uint32_t count) {
    return put(context, &((sd_inproc_t *)context)->to_ecu, events, count);
}

sd_port_t sd_inproc_ecu_side(sd_inproc_t *self) { return (sd_port_t){ self, ecu_receive, ecu_send }; }
sd_port_t sd_inproc_host_side(sd_inproc_t *self) { return (sd_port_t){ self, host_receive, host_send }; }
