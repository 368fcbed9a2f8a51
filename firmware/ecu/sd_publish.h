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

typedef struct sd_publish {
    sd_signals_t signals;                ///< Present values.
    sd_status_t  status[SD_OWNER_COUNT]; ///< Health of each owner's signals.
    uint32_t     row_flags[SD_OWNER_COUNT]; ///< Health and reasons as they were when the row in parts that is under way began.
    uint32_t     unsent;                 ///< Events that the port had no room for, wraps.
} sd_publish_t;

/// Every owner begins invalid, without sync.
void sd_publish_init(sd_publish_t *self);

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
