/* SPDX-License-Identifier: MIT */
/// sd_lcm_codec.h - events to LCM messages and back, as sixdeg.lcm says. No network: sd_lcm.h has that.
#ifndef SD_LCM_CODEC_H
#define SD_LCM_CODEC_H
#include "sd_role.h"
#include "sd_lcm_rows.h"
#include "sixdeg_claim_t.h"
#include "sixdeg_inputs_t.h"
#include "sixdeg_outputs_t.h"
#include "sixdeg_parameter_t.h"
#include "sixdeg_truth_t.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_LCM_TRUTHS 1024u ///< Decoded truths that may wait, a power of two.

/// Zero it, then set role and session. Caller-owned.
typedef struct sd_lcm_codec {
    sd_role_t role;
    uint16_t  session;                   ///< Drawn anew at each start.
    int32_t   sequence;                  ///< Of the next inputs message to send.
    sixdeg_event_t event[SD_LCM_ROWS];   ///< Going out.
    int32_t   events;                    ///< How many go out.
    sd_lcm_rows_t rows;                  ///< Going out.
    sixdeg_truth_edge_t  truth_edge[SD_LCM_ROWS];
    sixdeg_truth_cycle_t truth_cycle[SD_LCM_ROWS];
    int32_t   truth_edges, truth_cycles, sent_edges, sent_cycles; ///< Truth going out; truth sent since the start.
    sd_row_t  row[SD_RATE_COUNT];        ///< Being collected.
    sd_order_t order;
    uint16_t  peer_session;              ///< Session of the other side, as heard last.
    uint8_t   peer_seen;                 ///< 1: there was one.
    uint32_t  peer_starts;               ///< Times the ecu on the other side has started anew.
    sd_claim_t claim;
    uint8_t   claim_heard;               ///< 1: `claim` waits to be taken.
    sd_queue_t in;
    sd_truth_t truth[SD_LCM_TRUTHS];     ///< Decoded, for a tool.
    uint32_t   truth_written, truth_read; ///< Of `truth`; both run on and wrap together.
    sd_port_counts_t counts;
} sd_lcm_codec_t;

/// The channels, and what each takes.
typedef enum sd_lcm_channel {
    SD_LCM_INPUTS,            ///< Events of the plant, to the ecu.
    SD_LCM_OUTPUTS,           ///< What the ecu says.
    SD_LCM_TRUTH,             ///< Truth of the plant, past the ecu.
    SD_LCM_PARAMETER_REQUEST, ///< Of a tool, to the ecu.
    SD_LCM_PARAMETER,         ///< The ecu's answer to that.
    SD_LCM_CLAIM,             ///< Who answers for an ecu.
    SD_LCM_CHANNELS           ///< Their number.
} sd_lcm_channel_t;
/// By sd_lcm_channel_t.
extern const char *const sd_lcm_channel_names[SD_LCM_CHANNELS];

/// 1: this role listens to the channel.
int sd_lcm_listens(sd_role_t role, sd_lcm_channel_t channel);
/// Takes any bytes at all as a message of `channel`.
void sd_lcm_decode(sd_lcm_codec_t *self, sd_lcm_channel_t channel, const void *bytes, int size);
/// A row's event joins what goes out.
void sd_lcm_add_signal(sd_lcm_codec_t *self, const sd_event_t *event);

#ifdef __cplusplus
}
#endif

#endif
