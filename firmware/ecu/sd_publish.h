/* SPDX-License-Identifier: MIT */
/// sd_publish.h - what the ecu says: present values and health of every signal, and how they leave through a port.
///
/// Stages hand values on; the ecu writes them here. A row is all signals of one rate. Long rows leave in parts, a part a tooth:
/// every event of a row carries the tick of the event that caused the row.
#ifndef SD_PUBLISH_H
#define SD_PUBLISH_H
#include <stdbool.h>

#include "hal.h"
#include "sd_signals.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_PUBLISH_PART 16u ///< Most events of one part; it also bounds the stack.

/// Where signals go, and with which tick.
typedef struct sd_publish {
    sd_signals_t signals;                ///< Present values.
    uint32_t     flags[SD_OWNER_COUNT];  ///< Of each owner's signals, as an event has them: health | why << 8.
    uint32_t     row_flags[SD_OWNER_COUNT]; ///< The same when the row in parts that is under way began.
    uint32_t     unsent;                 ///< Events that the port had no room for, wraps.
} sd_publish_t;

/// Every owner begins invalid, without sync.
void sd_publish_init(sd_publish_t *self);

/// What an owner's signals are worth from now on.
static inline void sd_publish_judge(sd_publish_t *self, sd_owner_t owner, const sd_status_t *status) {
    self->flags[owner] = status->health | ((uint32_t)status->why << 8);
}

/// That is no better than `health` from now on, and `why` says more of it.
static inline void sd_publish_worst_of(sd_publish_t *self, sd_owner_t owner, uint8_t health, uint16_t why) {
    const uint32_t flags = self->flags[owner], before = flags & 0xffu;
    self->flags[owner] = (flags & ~0xffu) | ((uint32_t)why << 8) | ((health > before) ? health : before);
}

/// What they are worth now: health and why, the rest is 0.
static inline sd_status_t sd_publish_judged(const sd_publish_t *self, sd_owner_t owner) {
    return (sd_status_t){ .why = (uint16_t)(self->flags[owner] >> 8), .rejected = 0, .health = (uint8_t)self->flags[owner],
                          .innovation = 0.0f, .test_ratio = 0.0f };
}

/// Sends a part of the row of a rate, from its signal number `from` on; returns the number of the next one, or 0 when the row is
/// complete. The health of its owners is that of its first part: a bus carries it once a row. One row of several parts may be
/// under way at a time.
uint32_t sd_publish_part(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate, uint32_t from);

/// Sends the whole row.
void sd_publish_row(sd_publish_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate);

#ifdef __cplusplus
}
#endif
#endif
