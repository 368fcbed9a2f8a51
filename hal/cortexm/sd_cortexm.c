/* SPDX-License-Identifier: MIT */
#include "sd_cortexm.h"

#include <string.h>

#include "sd_shed.h"

void sd_cortexm_init(sd_cortexm_t *self) {
    memset(self, 0, sizeof *self);
    self->patience = SD_CORTEXM_PATIENCE;
}

/* ---- written by interrupts ------------------------------------------------------------------------------------------ */

void sd_cortexm_edge(sd_cortexm_t *self, sd_event_kind_t kind, uint32_t tick) {
    if (kind == SD_EVENT_CRANK_EDGE) {
        if (self->crank_seen != self->crank_done) { self->overruns++; }
        self->crank_seen++;
    }
    if (self->edges_written - self->edges_read >= SD_CORTEXM_EDGES) {
        self->lost_edges++;
        self->losing = 1;
        if (kind == SD_EVENT_CRANK_EDGE) { self->crank_seen--; } /* nobody will handle it */
        return;
    }
    self->edges[self->edges_written % SD_CORTEXM_EDGES] = (sd_event_t){ .tick = tick, .kind = (uint16_t)kind, .flags = self->losing };
    self->losing = 0;
    self->edges_written++;
}

void sd_cortexm_post(sd_cortexm_t *self, const sd_event_t *event) {
    if ((event->kind == (uint16_t)SD_EVENT_TIME) && (self->task != 0u)) { self->tasks_late++; }
    if (self->others_written - self->others_read >= SD_CORTEXM_OTHERS) {
        self->lost_others++;
        return;
    }
    self->others[self->others_written % SD_CORTEXM_OTHERS] = *event;
    self->others_written++;
}

void sd_cortexm_task_done(sd_cortexm_t *self) {
    if (self->task == 1u) { self->task = 2u; }
}

/* ---- read by the work ------------------------------------------------------------------------------------------------ */

static void change_level(sd_cortexm_t *self, uint8_t level, uint32_t tick, sd_event_t *event) {
    self->level = level;
    self->calm = 0;
    *event = (sd_event_t){ .tick = tick, .kind = SD_EVENT_LATE, .value = level, .flags = self->overruns };
}

/* True when the ecu is to be told of another level before the edge that waits. */
static bool judge(sd_cortexm_t *self, uint32_t tick, sd_event_t *event) {
    const uint32_t overruns = self->overruns;
    if (overruns != self->overruns_answered) {
        self->overruns_answered = overruns;
        if (self->taken_back != 0u) { /* too early, if it was not long ago */
            const bool soon = self->calm < self->patience;
            if (!soon) { self->patience = SD_CORTEXM_PATIENCE; }
            if (soon && (self->patience < SD_CORTEXM_PATIENCE_MAX)) { self->patience *= 2u; }
        }
        self->taken_back = 0;
        if (self->level < (uint8_t)SD_SHED_MOST) {
            change_level(self, (uint8_t)(self->level + 1u), tick, event);
            return true;
        }
        self->calm = 0;
        return false;
    }
    if ((self->level == 0u) || (self->calm < self->patience)) { return false; }
    self->taken_back = 1;
    change_level(self, (uint8_t)(self->level - 1u), tick, event);
    return true;
}

static bool next_edge(sd_cortexm_t *self, sd_event_t *event) {
    if (self->edges_read == self->edges_written) { return false; }
    sd_event_t *edge = &self->edges[self->edges_read % SD_CORTEXM_EDGES];
    if (judge(self, edge->tick, event)) { return true; }
    if (edge->flags != 0u) { /* edges are missing before it */
        *event = (sd_event_t){ .tick = edge->tick, .kind = SD_EVENT_GAP };
        edge->flags = 0;
        return true;
    }
    *event = *edge;
    self->edges_read++;
    self->handling = (event->kind == (uint16_t)SD_EVENT_CRANK_EDGE) ? 1u : 0u;
    if (self->calm < SD_CORTEXM_PATIENCE_MAX) { self->calm += self->handling; }
    return true;
}

/* While the task is under way nothing but edges. */
static bool next_task(sd_cortexm_t *self, sd_event_t *event) {
    if (self->task == 1u) { return false; }
    const uint32_t late = self->tasks_late;
    *event = (sd_event_t){ .tick = self->task_tick, .kind = SD_EVENT_TASK, .value = late - self->tasks_late_said };
    self->tasks_late_said = late;
    self->task = 0;
    return true;
}

bool sd_cortexm_next(sd_cortexm_t *self, sd_event_t *event) {
    self->crank_done += self->handling;
    self->handling = 0;
    if (next_edge(self, event)) { return true; }
    if (self->task != 0u) { return next_task(self, event); }
    if (self->others_read == self->others_written) { return false; }
    *event = self->others[self->others_read % SD_CORTEXM_OTHERS];
    self->others_read++;
    if (event->kind == (uint16_t)SD_EVENT_TIME) {
        event->flags = SD_TIME_PUT_OFF;
        self->task_tick = event->tick;
        self->task = 1;
    }
    return true;
}
