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

#ifdef __cplusplus
extern "C" {
#endif
#ifdef SD_KERNEL
#error "a kernel must not include hal.h: data reaches it through the ecu"
#endif

/// What an event is.
typedef enum sd_event_kind {
    SD_EVENT_CRANK_EDGE = 1,  ///< In. tick: capture time of an edge of the crank wheel.
    SD_EVENT_CAM_EDGE   = 2,  ///< In. tick: capture time of the cam edge.
    SD_EVENT_TIME       = 3,  ///< In, every 10 ms. tick: now; flags: SD_TIME_PUT_OFF or 0. Answered by SD_EVENT_DONE.
    SD_EVENT_SAMPLE     = 4,  ///< In. A sensor was read at tick. channel: sd_input_t; value: IEEE 754 bits.
    SD_EVENT_WHEEL_EDGE = 5,  ///< In. tick: capture time of an edge of another toothed wheel; channel: sd_wheel_t. Taken where the
                              ///< page has a driveline with such teeth; otherwise it is neither counted as unknown nor answered.
    SD_EVENT_GAP        = 8,  ///< In. A port lost events before this one: the angle is sought afresh.
    SD_EVENT_PARAMETER  = 9,  ///< In. channel: index of the parameter; flags: sd_parameter_command_t; value: to set.
                              ///< Out, its answer. value: what holds now; flags: command | sd_parameter_result_t << 8.
    SD_EVENT_LATE       = 10, ///< In. From here on the port lets the ecu leave out work, since teeth come faster than they are handled.
                              ///< value: how much, sd_shed_t; flags: teeth that came too early so far, wraps.
    SD_EVENT_TASK       = 11, ///< In. What the last SD_EVENT_TIME put off is done (sd_ecu_task_run, else it is done here) and is said now.
                              ///< value: further clock events that came due before it was done; above 0 it was late.
    SD_EVENT_SIGNAL     = 16, ///< Out. channel: sd_signal_t; value: IEEE 754 bits; flags: health | why << 8 (16 bits).
    SD_EVENT_DONE       = 17, ///< Out. tick: of the SD_EVENT_TIME up to which all is handled and said; value: signals
                              ///< the port had no room for; flags: events ignored since the start.
} sd_event_kind_t;

#define SD_TIME_PUT_OFF 1u ///< The long part of the 10 ms task, and what follows it, wait for SD_EVENT_TASK.

/// Toothed wheels beside crank and cam. A bus has room for 14.
typedef enum sd_wheel {
    SD_WHEEL_FRONT_LEFT     = 0, ///< Wheel speeds, as an ABS unit reads them.
    SD_WHEEL_FRONT_RIGHT    = 1, ///< The same of this wheel.
    SD_WHEEL_REAR_LEFT      = 2, ///< The same of this wheel.
    SD_WHEEL_REAR_RIGHT     = 3, ///< The same of this wheel.
    SD_WHEEL_GEARBOX_OUTPUT = 4, ///< Output shaft of the gearbox.
} sd_wheel_t;

/// What an SD_EVENT_PARAMETER asks for. There are two pages: the working one rules, the reference one never changes.
typedef enum sd_parameter_command {
    SD_PARAMETER_READ           = 0, ///< The working value.
    SD_PARAMETER_READ_REFERENCE = 1, ///< The reference value.
    SD_PARAMETER_SET            = 2, ///< Makes `value` the working value.
    SD_PARAMETER_RESTORE        = 3, ///< Makes the reference value the working one; of SD_PARAMETER_ALL, the whole page.
} sd_parameter_command_t;
#define SD_PARAMETER_ALL 255u ///< In place of an index.

/// What became of the request.
typedef enum sd_parameter_result {
    SD_PARAMETER_OK      = 0, ///< Done; the event holds the working value, or the reference value that was asked for.
    SD_PARAMETER_UNKNOWN = 1, ///< No such parameter or command; nothing changed.
    SD_PARAMETER_RANGE   = 2, ///< Outside its range, NaN included; nothing changed.
    SD_PARAMETER_REFUSED = 3, ///< In range, but its block cannot run with it; nothing changed.
    SD_PARAMETER_AT_START = 4, ///< It goes into tables that the host makes, so only a new page changes it; nothing changed.
} sd_parameter_result_t;

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
    void *context; ///< Handed to both functions.
    /// Moves up to `room` waiting events to `events`; returns how many.
    uint32_t (*receive)(void *context, sd_event_t *events, uint32_t room);
    /// Takes `count` events; returns how many it had room for.
    uint32_t (*send)(void *context, const sd_event_t *events, uint32_t count);
} sd_port_t;

#ifdef __cplusplus
}
#endif

#endif
