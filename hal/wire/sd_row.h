/* SPDX-License-Identifier: MIT */
/// sd_row.h - what CAN and LCM share: between single events and what travels together.
///
/// A row is all signals of one rate at one tick. Ports collect the events of a row, send it as one, and hand it out as
/// events again. An order tells on the other side whether something went missing on the way.
#ifndef SD_ROW_H
#define SD_ROW_H
#include <string.h>

#include "hal.h"
#include "sd_signals.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Signals of one rate and tick while they are collected. Zero it to begin.
typedef struct sd_row {
    uint32_t tick;                      ///< Capture ticks, that of its events.
    uint8_t  rate;                      ///< sd_rate_t.
    uint16_t left;                      ///< Channels of its rate that it does not hold yet.
    uint8_t  health[SD_OWNER_COUNT];    ///< sd_health_t.
    uint16_t why[SD_OWNER_COUNT];       ///< sd_why_t bits.
    uint8_t  present[SD_SIGNAL_COUNT];  ///< 1: this channel is in the row.
    float    value[SD_SIGNAL_COUNT];    ///< By channel, in the unit of the signal.
} sd_row_t;

/// Empties a row for a tick and a rate.
static inline void sd_row_begin(sd_row_t *row, uint32_t tick, uint8_t rate) {
    memset(row, 0, sizeof *row);
    row->tick = tick;
    row->rate = rate;
    row->left = (uint16_t)sd_rate_infos[rate].count;
}

/// Notes how far an owner is to be trusted: sd_health_t, sd_why_t bits.
static inline void sd_row_status(sd_row_t *row, uint32_t owner, uint8_t health, uint16_t why) {
    row->health[owner] = health;
    row->why[owner] = why;
}

/// Notes a signal's value, in its unit.
static inline void sd_row_put(sd_row_t *row, uint32_t channel, float value) {
    row->left = (uint16_t)(row->left - (1u - row->present[channel]));
    row->present[channel] = 1;
    row->value[channel] = value;
}

#define SD_QUEUE_EVENTS 4096u ///< A power of two; more than 10 ms at the highest speed cause.
/// Events waiting at one end of a port. Zero it to begin.
typedef struct sd_queue {
    sd_event_t events[SD_QUEUE_EVENTS];
    uint32_t   written, read; ///< Both run on and wrap together.
    uint32_t   overrun;       ///< Events that found it full.
} sd_queue_t;

/// Adds an event; where there is no room it is counted in `overrun`.
void     sd_queue_put(sd_queue_t *queue, const sd_event_t *event);
/// Moves up to `room` events to `events`; returns how many.
uint32_t sd_queue_take(sd_queue_t *queue, sd_event_t *events, uint32_t room);

/// Adds an SD_EVENT_SIGNAL to the row of its rate; `rows` holds one for each, zeroed to begin. Returns that row when it now
/// holds every channel of its rate and may go, else NULL. Rows of different rates may come in pieces, one between the
/// others. A piece of another tick, or a channel said twice, begins a row anew: the one before was torn.
const sd_row_t *sd_row_take(sd_row_t rows[SD_RATE_COUNT], const sd_event_t *event);

/// The row as events, in order of channels. 0, and nothing queued, when a health is none or a value no finite number.
int sd_row_events(const sd_row_t *row, sd_queue_t *queue);

/// Order of the messages of one sender. Zero it to begin.
typedef struct sd_order {
    uint16_t next, session;         ///< Number that is expected; session of the sender.
    uint8_t  started, stale_in_row; ///< 1: a message was seen; stale ones in a row.
    uint32_t starts; ///< Times the sender has started anew.
} sd_order_t;

/// What a message is, by its number.
typedef enum sd_arrival {
    SD_ARRIVAL_NEXT,  ///< As expected.
    SD_ARRIVAL_GAP,   ///< Messages before it are lost, or the sender has started anew.
    SD_ARRIVAL_STALE, ///< Came before, or came too late: leave it out.
} sd_arrival_t;

/// A message that says `sequence` is its number (step 1), or the number of the next one (step 0).
sd_arrival_t sd_order_check(sd_order_t *order, uint16_t session, uint16_t sequence, uint16_t step);

/// What became of messages; all wrap.
typedef struct sd_port_counts {
    uint32_t sent, received; ///< Taken by the bus; taken off it.
    uint32_t unsent;    ///< Gone, because nobody took them off the bus for too long or the bus is down.
    uint32_t foreign;   ///< Not ours.
    uint32_t malformed; ///< Ours by name, with a wrong length or content.
    uint32_t gaps;      ///< Times messages were missing.
    uint32_t stale;     ///< Doubled or late.
} sd_port_counts_t;

/// Truth, which travels past the ecu: same meaning as in sixdeg.dbc.
typedef struct sd_truth_edge {
    double   time_s, angle_deg, crank_deg, speed_radps, net_torque_nm; ///< Angle of the cycle, and unwrapped; torque at the crank.
    uint32_t tick;         ///< Capture ticks of the edge.
    uint8_t  tooth, flags; ///< Position on the wheel; bits: false edge, backward.
} sd_truth_edge_t;

/// The same of a cylinder's cycle.
typedef struct sd_truth_cycle {
    double  torque_nm, imep_pa, tdc_time_s, exhaust_lambda; ///< Mean combustion torque; its pressure; time of firing TDC; of its gas.
    int32_t cycle;             ///< From 0.
    uint8_t cylinder, misfire; ///< Physical, from 1; 1: it did not burn.
} sd_truth_cycle_t;

/// The run is over; so much truth was sent.
typedef struct sd_truth_end {
    uint32_t edges, cycles; ///< Of each kind.
} sd_truth_end_t;

/// Any of these.
typedef struct sd_truth {
    enum {
        SD_TRUTH_EDGE,  ///< `edge` counts.
        SD_TRUTH_CYCLE, ///< `cycle` counts.
        SD_TRUTH_END    ///< `end` counts.
    } kind;
    union {
        sd_truth_edge_t  edge;
        sd_truth_cycle_t cycle;
        sd_truth_end_t   end;
    };
} sd_truth_t;

/// Somebody who answers for an ecu, or asks for one: sixdeg.dbc, claim.
typedef struct sd_claim {
    uint32_t id, signature; ///< Who it is; SD_SIGNALS_SIGNATURE of its table of signals.
} sd_claim_t;
#define SD_CLAIM_RUNNING 0u          ///< id of an ecu that is running and stays.
#define SD_CLAIM_WHO     0xffffffffu ///< id of one who asks whether there is an ecu.

#ifdef __cplusplus
}
#endif

#endif
