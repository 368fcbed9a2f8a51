/* SPDX-License-Identifier: MIT */
/// hal.h - the one boundary: a stream of small events in, a stream of small events out.
///
/// A port (in-process, bus, bare metal, log) moves events and knows nothing of what they mean; the ecu consumes and
/// produces them and knows nothing of where they go. Because every port carries the same stream, any run can be
/// recorded on one and replayed on another. Kernels never see this header: there is no include path to it, and the
/// line below refuses a relative include.
#ifndef SD_HAL_H
#define SD_HAL_H
#include <stdint.h>
#ifdef SD_KERNEL
#error "a kernel must not include hal.h: data reaches it through the ecu"
#endif

/// What an event is.
typedef enum sd_event_kind {
    SD_EVENT_CRANK_EDGE = 1,  ///< In. tick: capture time of an edge of the crank wheel.
    SD_EVENT_CAM_EDGE   = 2,  ///< In. tick: capture time of the cam edge.
    SD_EVENT_TIME       = 3,  ///< In, every 10 ms. tick: now.
    SD_EVENT_SAMPLE     = 4,  ///< In. A sensor was read at tick. channel: sd_input_t; value: IEEE 754 bits.
    SD_EVENT_SIGNAL     = 16, ///< Out. channel: sd_signal_t; value: IEEE 754 bits; flags: health | why << 8.
} sd_event_kind_t;

/// One event, 16 bytes.
typedef struct sd_event {
    uint32_t tick;    ///< Capture ticks, wraps; for outputs the tick of the event that caused them.
    uint16_t kind;    ///< sd_event_kind_t; unknown kinds are ignored and counted.
    uint16_t channel; ///< Which sensor or signal of that kind.
    uint32_t value;   ///< By kind; 0 where unused.
    uint32_t flags;   ///< By kind; 0 where unused.
} sd_event_t;

/// A port: two functions and their context. Neither blocks.
typedef struct sd_port {
    void *context;
    /// Moves up to `room` waiting events to `events`; returns how many.
    uint32_t (*receive)(void *context, sd_event_t *events, uint32_t room);
    /// Takes `count` events; returns how many it had room for.
    uint32_t (*send)(void *context, const sd_event_t *events, uint32_t count);
} sd_port_t;

#endif
