/* SPDX-License-Identifier: MIT */
/* Events, one by one, as they come from the port; the same in both kinds of ecu. What a tooth and a sample mean is theirs. */
#include <string.h>

#include "sd_ecu_parts.h"
#include "sd_say_edge.h"

static void on_crank_edge(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, uint32_t tick) {
    sd_tooth_t tooth;
    sd_crank_edge(&self->crank, tick, &tooth);
    const float speed_radps = sd_ecu_say_edge(self, page, &tooth);
    if (tooth.edge_class == (uint8_t)SD_EDGE_UNSYNCED) {
        sd_ecu_lose_angle(self, SD_WHY_NO_SYNC);
        sd_ecu_do_piece(self, page, port);
    } else if (tooth.edge_class != (uint8_t)SD_EDGE_SPURIOUS) {
        sd_ecu_tooth(self, page, port, &tooth, speed_radps);
    } else {
        sd_ecu_spurious(self, page);
    }
    self->edge_seen = 1;
    sd_publish_row(&self->say, port, tick, SD_RATE_EDGE);
}

static void publish_lost_angle(sd_ecu_t *self, const sd_port_t *port, uint32_t tick, uint16_t why) {
    sd_ecu_lose_angle(self, why);
    sd_say_lost_angle(&self->say, SD_INVALID, why);
    sd_publish_row(&self->say, port, tick, SD_RATE_EDGE);
}

static void on_sample(sd_ecu_t *self, const sd_event_t *event) {
    float value;
    memcpy(&value, &event->value, sizeof value);
    if (sd_inputs_take(&self->inputs, event->channel, event->tick, value)) { sd_ecu_sample(self, (sd_input_t)event->channel, value); }
}

void sd_ecu_task_run(sd_ecu_t *self, const sd_calibration_t *page) {
    if (self->task != (uint8_t)SD_TASK_DUE) { return; }
    sd_ecu_task_work(self, page);
    self->task = SD_TASK_DONE;
}

/* The 10 ms task is said. late: clock events that came before it was done. */
static void on_task(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, uint32_t late) {
    if (self->task == (uint8_t)SD_TASK_NONE) { return; }
    sd_ecu_task_run(self, page);
    self->task = SD_TASK_NONE;
    sd_ecu_task_say(self, page, port, (late > 0u) ? (uint16_t)SD_WHY_OVERLOAD : 0u);
    sd_say_inputs(&self->say, &self->inputs);
    sd_publish_row(&self->say, port, self->task_tick, SD_RATE_TASK);
    const sd_event_t done = { .tick = self->task_tick, .kind = SD_EVENT_DONE, .value = self->say.unsent, .flags = self->unknown_events };
    (void)port->send(port->context, &done, 1u);
}

static void on_time(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_event_t *event) {
    const uint32_t tick = event->tick;
    on_task(self, page, port, 0u); /* nothing where the last one was said, as a port makes sure */
    sd_inputs_age(&self->inputs, tick, page->tick_hz);
    if (sd_crank_poll(&self->crank, tick)) { publish_lost_angle(self, port, tick, SD_WHY_STALL); }
    if (self->edge_seen == 0u) { sd_ecu_do_piece(self, page, port); } /* no tooth comes to do it */
    self->edge_seen = 0;
    sd_ecu_task_begin(self, page, tick);
    self->task = SD_TASK_DUE;
    if ((event->flags & SD_TIME_PUT_OFF) == 0u) { on_task(self, page, port, 0u); }
}

/* The decoder would take lost edges for a mark or a change of speed, so it starts afresh. */
static void on_gap(sd_ecu_t *self, const sd_port_t *port, uint32_t tick) {
    sd_crank_lose_sync(&self->crank);
    publish_lost_angle(self, port, tick, SD_WHY_NO_SYNC);
}

static void on_late(sd_ecu_t *self, uint32_t level) {
    const uint8_t most = (uint8_t)SD_SHED_MOST;
    sd_ecu_shed(self, (level < most) ? (uint8_t)level : most);
}

uint32_t sd_ecu_run(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port) {
    sd_event_t event;
    uint32_t handled = 0;
    while ((self->ready != 0u) && (port->receive(port->context, &event, 1u) == 1u)) {
        switch (event.kind) {
        case SD_EVENT_CRANK_EDGE: on_crank_edge(self, page, port, event.tick); break;
        case SD_EVENT_CAM_EDGE:   sd_crank_cam_edge(&self->crank, event.tick); break;
        case SD_EVENT_WHEEL_EDGE: sd_ecu_wheel(self, page, event.channel, event.tick); break;
        case SD_EVENT_TIME:       on_time(self, page, port, &event); break;
        case SD_EVENT_SAMPLE:     on_sample(self, &event); break;
        case SD_EVENT_GAP:        on_gap(self, port, event.tick); break;
        case SD_EVENT_TASK:       on_task(self, page, port, event.value); break;
        case SD_EVENT_LATE:       on_late(self, event.value); break;
        case SD_EVENT_PARAMETER:  sd_ecu_parameter(self, page, port, &event); break;
        default:                  self->unknown_events++; break;
        }
        handled++;
    }
    return handled;
}
