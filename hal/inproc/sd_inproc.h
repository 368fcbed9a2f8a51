/* SPDX-License-Identifier: MIT */
/// sd_inproc.h - the in-process port: two rings of events between a host and an ecu in one program. Single-threaded.
#ifndef SD_INPROC_H
#define SD_INPROC_H
#include "hal.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_INPROC_EVENTS 256u ///< A power of two; a ring holds that many.

/// Events on their way to one side.
typedef struct sd_inproc_ring {
    sd_event_t events[SD_INPROC_EVENTS];
    uint32_t   written, read; ///< Both run on and wrap together.
} sd_inproc_ring_t;

/// Zero it to begin. Caller-owned; the ports point into it.
typedef struct sd_inproc {
    sd_inproc_ring_t to_ecu, to_host;
    uint32_t dropped; ///< Events that found their ring full.
} sd_inproc_t;

/// The two ends; they live as long as *self does.
sd_port_t sd_inproc_ecu_side(sd_inproc_t *self);
sd_port_t sd_inproc_host_side(sd_inproc_t *self);

#ifdef __cplusplus
}
#endif

#endif
