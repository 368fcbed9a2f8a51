/* SPDX-License-Identifier: MIT */
/// sd_can_codec.h - events to CAN frames and back, as sixdeg.dbc says. No socket: sd_can.h has that.
#ifndef SD_CAN_CODEC_H
#define SD_CAN_CODEC_H
#include "sd_role.h"
#include "sd_row.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_CAN_TRUTH_FIRST 0xf0u ///< Identifiers of truth: 0xf0 to 0xf3.

/// A frame on the bus.
typedef struct sd_frame {
    uint32_t id;                     ///< Standard identifier, 11 bits.
    uint8_t  fd, length, bytes[64];  ///< 1: CAN FD; bytes that count; those.
} sd_frame_t;

#define SD_CAN_FRAMES 512u ///< A power of two.
#define SD_CAN_TEETH  13u  ///< Ticks in a teeth frame.

/// Zero it, then set role and session. Caller-owned.
typedef struct sd_can_codec {
    sd_role_t role;
    uint16_t  session;     ///< Drawn anew at each start.
    uint16_t  sequence;    ///< Of the next teeth frame to send.
    uint32_t  tick[SD_CAN_TEETH]; ///< Of edges that wait for their frame.
    uint8_t   edge[SD_CAN_TEETH]; ///< Of which wheel each tick is an edge, as in sixdeg.dbc.
    uint8_t   ticks;       ///< How many wait.
    sd_row_t  row[SD_RATE_COUNT]; ///< Being collected.
    sd_order_t order;      ///< Of the plant's teeth frames.
    uint16_t  peer_session; ///< Session of the other side, as heard last.
    uint8_t   peer_seen;   ///< 1: there was one.
    uint32_t  peer_starts; ///< Times the ecu on the other side has started anew.
    sd_claim_t claim;      ///< The last one heard, and not yet taken.
    uint8_t   claim_heard; ///< 1: `claim` waits to be taken.
    sd_queue_t in;         ///< Decoded events.
    sd_frame_t out[SD_CAN_FRAMES];
    uint32_t   written, read; ///< Of `out`; both run on and wrap together.
    sd_truth_t truth;      ///< Decoded truth, when sd_can_decode returned 1.
    sd_port_counts_t counts;
} sd_can_codec_t;

/// Queues the frames of an event. 0: there was no room, and nothing was taken.
int sd_can_encode(sd_can_codec_t *self, const sd_event_t *event);
int sd_can_encode_truth(sd_can_codec_t *self, const sd_truth_t *truth);
int sd_can_encode_claim(sd_can_codec_t *self, sd_claim_t claim);

/// Takes any frame at all. 1: self->truth holds what it said.
int sd_can_decode(sd_can_codec_t *self, const sd_frame_t *frame);

#ifdef __cplusplus
}
#endif

#endif
