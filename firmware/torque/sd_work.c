/* SPDX-License-Identifier: MIT */
#include "sd_work.h"

#include <string.h>

#include "sd_scaled.h"

#define TICKS_MAX 0x3fffffffu /* two of them in 31 bits */

/* sd_work_meter_t.stage: before the window; in it, and its first tooth was good, or not. */
enum { AHEAD, GOOD, SPOILT };

_Static_assert(sizeof(sd_work_meter_t) == 20u + 4u * SD_WORK_WINDOWS_MAX + 4u, "without pointers, the same size on every target");

bool sd_work_tables_ok(const sd_work_tables_t *t) {
    bool ok = (t->windows <= SD_WORK_WINDOWS_MAX) && ((t->windows == 0u) || (t->cycle >= 2u));
    for (uint32_t i = 0; ok && (i < t->windows); ++i) {
        const sd_work_window_t *w = &t->window[i];
        ok = sd_bits_within(w->energy_jticks2, 1e-6f, 1e30f) && sd_bits_within(w->span_rad, 0.05f, 12.5f) && (w->first < t->cycle) &&
             (w->last < t->cycle) && (w->first != w->last);
    }
    return ok;
}

static uint32_t ahead(uint32_t from, uint32_t to, uint32_t cycle) { return (to > from) ? to - from : to + cycle - from; }

void sd_work_restart(sd_work_meter_t *self, const sd_work_tables_t *t, uint32_t cycle_position) {
    memset(self, 0, sizeof *self);
    self->waits = UINT16_MAX;
    uint32_t nearest = UINT32_MAX;
    for (uint32_t i = 0; i < t->windows; ++i) {
        const uint32_t distance = ahead(cycle_position, t->window[i].first, t->cycle);
        if (distance < nearest) {
            nearest = distance;
            self->at = (uint8_t)i;
            self->waits = t->window[i].first;
        }
    }
}

/* The window under way has passed. */
static void end_window(sd_work_meter_t *self, uint32_t ticks, bool good) {
    const uint8_t bit = (uint8_t)(1u << self->at);
    const bool before = (self->seen & bit) != 0u;
    self->ticks = good ? ticks : 0u;
    self->last_ticks = (good && before) ? self->passed_ticks[self->at] : 0u;
    self->passed_ticks[self->at] = self->ticks; /* 0 is not read: its bit is not set */
    self->seen = (uint8_t)(good ? (self->seen | bit) : (self->seen & ~(uint32_t)bit));
}

bool sd_work_edge(sd_work_meter_t *self, const sd_work_tables_t *t, uint32_t cycle_position, uint32_t tick, uint8_t trusted) {
    const bool there = cycle_position == self->waits, good = there && (trusted != 0u);
    if (!there) { self->seen = 0; } /* more may have been passed over */
    if (self->stage == (uint8_t)AHEAD) {
        self->begin_tick = tick;
        self->stage = good ? GOOD : SPOILT;
        self->waits = t->window[self->at].last;
        return false;
    }
    const uint32_t ticks = tick - self->begin_tick;
    end_window(self, ticks, good && (self->stage == (uint8_t)GOOD) && (ticks > 0u) && (ticks <= TICKS_MAX));
    self->stage = AHEAD;
    self->at = (uint8_t)((self->at + 1u < t->windows) ? self->at + 1u : 0u);
    self->waits = t->window[self->at].first;
    return true;
}
