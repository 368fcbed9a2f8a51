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

#define SD_LCM_TRUTHS 1024u

/// Zero it, then set role and session. Caller-owned.
typedef struct sd_lcm_codec {
    sd_role_t role;
    uint16_t  session;
    int32_t   sequence;                  ///< Of the next inputs message to send.
    sixdeg_event_t event[SD_LCM_ROWS];   ///< Going out.
    int32_t   events;
    sd_lcm_rows_t rows;                  ///< Going out.
    sixdeg_truth_edge_t  truth_edge[SD_LCM_ROWS];
    sixdeg_truth_cycle_t truth_cycle[SD_LCM_ROWS];
    int32_t   truth_edges, truth_cycles, sent_edges, sent_cycles;
    sd_row_t  row[SD_RATE_COUNT];        ///< Being collected.
    sd_order_t order;
    uint16_t  peer_session;
    uint8_t   peer_seen;
    uint32_t  peer_starts;
    sd_claim_t claim;
    uint8_t   claim_heard;
    sd_queue_t in;
    sd_truth_t truth[SD_LCM_TRUTHS];     ///< Decoded, for a tool.
    uint32_t   truth_written, truth_read;
    sd_port_counts_t counts;
} sd_lcm_codec_t;

/// The channels, and what each takes.
typedef enum sd_lcm_channel {
    SD_LCM_INPUTS, SD_LCM_OUTPUTS, SD_LCM_TRUTH, SD_LCM_PARAMETER_REQUEST, SD_LCM_PARAMETER, SD_LCM_CLAIM, SD_LCM_CHANNELS
} sd_lcm_channel_t;
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
