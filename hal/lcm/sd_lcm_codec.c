/* SPDX-License-Identifier: MIT */
#include "sd_lcm_codec.h"

const char *const sd_lcm_channel_names[SD_LCM_CHANNELS] = {
    "SIXDEG_INPUTS", "SIXDEG_OUTPUTS", "SIXDEG_TRUTH", "SIXDEG_PARAMETER_REQUEST", "SIXDEG_PARAMETER", "SIXDEG_CLAIM",
};

int sd_lcm_listens(sd_role_t role, sd_lcm_channel_t channel) {
    switch (channel) {
    case SD_LCM_INPUTS:
    case SD_LCM_PARAMETER_REQUEST: return role == SD_ROLE_ECU;
    case SD_LCM_OUTPUTS:           return role != SD_ROLE_ECU;
    case SD_LCM_TRUTH:
    case SD_LCM_PARAMETER:         return role == SD_ROLE_TOOL;
    default:                       return 1;
    }
}

void sd_lcm_add_signal(sd_lcm_codec_t *self, const sd_event_t *event) {
    const sd_row_t *row = sd_row_take(self->row, event);
    if ((row != NULL) && !sd_lcm_rows_add(&self->rows, row)) { self->counts.unsent++; }
}

/* ---- messages to events ---------------------------------------------------------------------------------------- */

_Static_assert(offsetof(sixdeg_outputs_t, done) == SD_RATE_COUNT * sizeof(int32_t),
               "each rate has its length at the head of an outputs message");

/* lcm-gen's decoders believe the lengths in a message and get memory for them, so these are looked at first. They are
   the first fields, big endian, after the 8 bytes of the type's fingerprint. */
static int length_is_sane(const void *bytes, int size, int field) {
    const uint8_t *at = (const uint8_t *)bytes + 8 + 4 * field;
    return (size >= 12 + 4 * field) && (at[0] == 0u) && (at[1] == 0u) && ((uint32_t)at[2] << 8 | at[3]) <= SD_LCM_ROWS;
}

/* What a plant may say; gaps are the port's own to tell, and parameters have their own channel. */
static int are_inputs(const sixdeg_inputs_t *m) {
    for (int32_t i = 0; i < m->count; ++i) {
        const uint16_t kind = (uint16_t)m->event[i].kind;
        if ((kind < (uint16_t)SD_EVENT_CRANK_EDGE) || (kind > (uint16_t)SD_EVENT_WHEEL_EDGE)) { return 0; }
    }
    return 1;
}

static int take_inputs(sd_lcm_codec_t *self, const void *bytes, int size) {
    sixdeg_inputs_t m;
    memset(&m, 0, sizeof m);
    if (!length_is_sane(bytes, size, 0)) { return 0; }
    const int whole = (sixdeg_inputs_t_decode(bytes, 0, size, &m) == size) && are_inputs(&m);
    if (whole) {
        const sd_arrival_t arrival = sd_order_check(&self->order, (uint16_t)m.session, (uint16_t)m.sequence, 1);
        if (arrival == SD_ARRIVAL_GAP) {
            const sd_event_t gap = { .tick = (m.count > 0) ? (uint32_t)m.event[0].tick : 0u, .kind = SD_EVENT_GAP };
            sd_queue_put(&self->in, &gap);
            self->counts.gaps++;
        }
        for (int32_t i = 0; (i < m.count) && (arrival != SD_ARRIVAL_STALE); ++i) {
            const sd_event_t event = { .tick = (uint32_t)m.event[i].tick, .kind = (uint16_t)m.event[i].kind,
                                       .channel = (uint16_t)m.event[i].channel, .value = (uint32_t)m.event[i].value,
                                       .flags = (uint32_t)m.event[i].flags };
            sd_queue_put(&self->in, &event);
        }
        self->counts.stale += arrival == SD_ARRIVAL_STALE;
    }
    (void)sixdeg_inputs_t_decode_cleanup(&m);
    return whole;
}

/* In the order in which the ecu said them. */
static int take_rows(sd_lcm_codec_t *self, const sixdeg_outputs_t *m) {
    sd_row_t row;
    int sound = 1;
    int32_t taken[SD_RATE_COUNT] = { 0 };
    while (sd_lcm_rows_next(&row, m, taken)) { sound &= sd_row_events(&row, &self->in); }
    return sound;
}

static int take_outputs(sd_lcm_codec_t *self, const void *bytes, int size) {
    sixdeg_outputs_t m;
    memset(&m, 0, sizeof m);
    for (int rate = 0; rate < (int)SD_RATE_COUNT; ++rate) {
        if (!length_is_sane(bytes, size, rate)) { return 0; }
    }
    int sound = sixdeg_outputs_t_decode(bytes, 0, size, &m) == size;
    if (sound) {
        if ((self->peer_seen != 0u) && ((uint16_t)m.session != self->peer_session)) { self->peer_starts++; }
        self->peer_seen = 1;
        self->peer_session = (uint16_t)m.session;
        sound = take_rows(self, &m);
        const sd_event_t done = { .tick = (uint32_t)m.tick, .kind = SD_EVENT_DONE, .value = (uint32_t)m.unsent,
                                  .flags = (uint32_t)m.ignored };
        if (m.done != 0) { sd_queue_put(&self->in, &done); }
    }
    (void)sixdeg_outputs_t_decode_cleanup(&m);
    return sound;
}

static void keep_truth(sd_lcm_codec_t *self, sd_truth_t truth) {
    if (self->truth_written - self->truth_read < SD_LCM_TRUTHS) { self->truth[self->truth_written++ % SD_LCM_TRUTHS] = truth; }
}

static int take_truth(sd_lcm_codec_t *self, const void *bytes, int size) {
    sixdeg_truth_t m;
    memset(&m, 0, sizeof m);
    if (!length_is_sane(bytes, size, 0) || !length_is_sane(bytes, size, 1)) { return 0; }
    const int whole = sixdeg_truth_t_decode(bytes, 0, size, &m) == size;
    if (whole) {
        for (int32_t i = 0; i < m.edges; ++i) {
            const sixdeg_truth_edge_t *e = &m.edge[i];
            keep_truth(self, (sd_truth_t){ .kind = SD_TRUTH_EDGE,
                                           .edge = { e->time_s, e->angle_deg, e->crank_deg, e->speed_radps, e->net_torque_nm,
                                                     (uint32_t)e->tick, (uint8_t)e->tooth, (uint8_t)e->flags } });
        }
        for (int32_t i = 0; i < m.cycles; ++i) {
            const sixdeg_truth_cycle_t *c = &m.cycle[i];
            keep_truth(self, (sd_truth_t){ .kind = SD_TRUTH_CYCLE,
                                           .cycle = { c->torque_nm, c->imep_pa, c->tdc_time_s, c->exhaust_lambda, c->cycle,
                                                     (uint8_t)c->cylinder, (uint8_t)c->misfire } });
        }
        if (m.end != 0) {
            keep_truth(self, (sd_truth_t){ .kind = SD_TRUTH_END, .end = { (uint32_t)m.sent_edges, (uint32_t)m.sent_cycles } });
        }
    }
    (void)sixdeg_truth_t_decode_cleanup(&m);
    return whole;
}

static int take_parameter(sd_lcm_codec_t *self, const void *bytes, int size) {
    sixdeg_parameter_t m;
    if (sixdeg_parameter_t_decode(bytes, 0, size, &m) != size) { return 0; }
    sd_event_t event = { .kind = SD_EVENT_PARAMETER, .channel = (uint16_t)m.index,
                         .flags = ((uint32_t)m.command & 0xffu) | ((uint32_t)m.result << 8) };
    memcpy(&event.value, &m.value, sizeof event.value);
    sd_queue_put(&self->in, &event);
    return 1;
}

static int take_claim(sd_lcm_codec_t *self, const void *bytes, int size) {
    sixdeg_claim_t m;
    if (sixdeg_claim_t_decode(bytes, 0, size, &m) != size) { return 0; }
    self->claim = (sd_claim_t){ (uint32_t)m.id, (uint32_t)m.signature };
    self->claim_heard = 1;
    return 1;
}

void sd_lcm_decode(sd_lcm_codec_t *self, sd_lcm_channel_t channel, const void *bytes, int size) {
    int sound = 0;
    self->counts.received++;
    switch (channel) {
    case SD_LCM_INPUTS:            sound = take_inputs(self, bytes, size); break;
    case SD_LCM_OUTPUTS:           sound = take_outputs(self, bytes, size); break;
    case SD_LCM_TRUTH:             sound = take_truth(self, bytes, size); break;
    case SD_LCM_PARAMETER_REQUEST:
    case SD_LCM_PARAMETER:         sound = take_parameter(self, bytes, size); break;
    case SD_LCM_CLAIM:             sound = take_claim(self, bytes, size); break;
    default: break;
    }
    self->counts.malformed += sound == 0;
}
