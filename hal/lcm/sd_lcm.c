/* SPDX-License-Identifier: MIT */
#include "sd_lcm.h"

#include <stdlib.h>

enum { MESSAGES_A_READ = 1000 }; /* so that no flood of what is no event keeps a reader for ever */

static void on_message(const lcm_recv_buf_t *message, const char *channel, void *context) {
    sd_lcm_codec_t *codec = context;
    for (int c = 0; c < SD_LCM_CHANNELS; ++c) {
        if (strcmp(channel, sd_lcm_channel_names[c]) == 0) {
            sd_lcm_decode(codec, (sd_lcm_channel_t)c, message->data, (int)message->data_size);
        }
    }
}

/* An ecu also hears its own claims; lcm has no way to leave out one's own, so they carry an id. */
int sd_lcm_open(sd_lcm_t *self, const char *url, sd_role_t role, uint16_t session) {
    memset(self, 0, sizeof *self);
    self->codec.role = role;
    self->codec.session = session;
    self->lcm = lcm_create((url[0] != '\0') ? url : NULL);
    if (self->lcm == NULL) { return -1; }
    for (int c = 0; c < SD_LCM_CHANNELS; ++c) {
        if (!sd_lcm_listens(role, (sd_lcm_channel_t)c)) { continue; }
        lcm_subscription_t *subscription = lcm_subscribe(self->lcm, sd_lcm_channel_names[c], on_message, &self->codec);
        if (subscription != NULL) { (void)lcm_subscription_set_queue_capacity(subscription, 1000); }
    }
    return 0;
}

void sd_lcm_close(sd_lcm_t *self) {
    if (self->lcm != NULL) { lcm_destroy(self->lcm); }
    self->lcm = NULL;
}

/* ---- out ------------------------------------------------------------------------------------------------------- */

static void publish(sd_lcm_t *self, sd_lcm_channel_t channel, const void *bytes, int size) {
    const int ok = (size > 0) && (lcm_publish(self->lcm, sd_lcm_channel_names[channel], bytes, (unsigned)size) == 0);
    self->codec.counts.sent += (uint32_t)ok;
    self->codec.counts.unsent += 1u - (uint32_t)ok;
}

/* Encodes message `m` of type `type` and publishes it. */
#define PUBLISH(self, channel, type, m)                                                                                \
    do {                                                                                                               \
        const int size = type##_encoded_size(m);                                                                       \
        uint8_t *bytes = malloc((size_t)size);                                                                         \
        publish(self, channel, bytes, (bytes != NULL) ? type##_encode(bytes, 0, size, m) : 0);                         \
        free(bytes);                                                                                                   \
    } while (0)

static void publish_truth(sd_lcm_t *self, int end) {
    sd_lcm_codec_t *c = &self->codec;
    if ((c->truth_edges == 0) && (c->truth_cycles == 0) && (end == 0)) { return; }
    c->sent_edges += c->truth_edges;
    c->sent_cycles += c->truth_cycles;
    const sixdeg_truth_t m = { .edges = c->truth_edges, .cycles = c->truth_cycles, .end = end, .sent_edges = c->sent_edges,
                               .sent_cycles = c->sent_cycles, .edge = c->truth_edge, .cycle = c->truth_cycle };
    PUBLISH(self, SD_LCM_TRUTH, sixdeg_truth_t, &m);
    c->truth_edges = c->truth_cycles = 0;
}

static void publish_inputs(sd_lcm_t *self) {
    sd_lcm_codec_t *c = &self->codec;
    const sixdeg_inputs_t m = { .count = c->events, .sequence = c->sequence, .session = c->session, .event = c->event };
    PUBLISH(self, SD_LCM_INPUTS, sixdeg_inputs_t, &m);
    c->sequence = (c->sequence + 1) & 0xffff;
    c->events = 0;
}

static void publish_outputs(sd_lcm_t *self, const sd_event_t *done) {
    sd_lcm_codec_t *c = &self->codec;
    sixdeg_outputs_t m = { .session = c->session };
    sd_lcm_rows_to_message(&m, &c->rows);
    if (done != NULL) {
        m.done = 1;
        m.tick = (int32_t)done->tick;
        m.ignored = (int32_t)done->flags;
        m.unsent = (int32_t)done->value;
    }
    PUBLISH(self, SD_LCM_OUTPUTS, sixdeg_outputs_t, &m);
    sd_lcm_rows_clear(&c->rows);
}

static void send_input(sd_lcm_t *self, const sd_event_t *event) {
    sd_lcm_codec_t *c = &self->codec;
    c->event[c->events++] = (sixdeg_event_t){ .tick = (int32_t)event->tick, .kind = (int16_t)event->kind,
                                              .channel = (int16_t)event->channel, .value = (int32_t)event->value,
                                              .flags = (int32_t)event->flags };
    if ((event->kind == SD_EVENT_TIME) || (c->events == SD_LCM_ROWS)) { publish_inputs(self); }
    if (event->kind == SD_EVENT_TIME) { publish_truth(self, 0); }
}

static void send_parameter(sd_lcm_t *self, const sd_event_t *event) {
    sixdeg_parameter_t m = { .command = (int32_t)(event->flags & 0xffu), .index = event->channel,
                             .result = (int32_t)(event->flags >> 8) };
    memcpy(&m.value, &event->value, sizeof m.value);
    PUBLISH(self, (self->codec.role == SD_ROLE_ECU) ? SD_LCM_PARAMETER : SD_LCM_PARAMETER_REQUEST, sixdeg_parameter_t, &m);
}

static uint32_t send_events(void *context, const sd_event_t *events, uint32_t count) {
    sd_lcm_t *self = context;
    sd_lcm_codec_t *c = &self->codec;
    for (uint32_t i = 0; i < count; ++i) {
        switch (events[i].kind) {
        case SD_EVENT_SIGNAL:
            sd_lcm_add_signal(c, &events[i]);
            if (sd_lcm_rows_full(&c->rows)) { publish_outputs(self, NULL); }
            break;
        case SD_EVENT_DONE:      publish_outputs(self, &events[i]); break;
        case SD_EVENT_PARAMETER: send_parameter(self, &events[i]); break;
        default:                 send_input(self, &events[i]); break;
        }
    }
    return count;
}

void sd_lcm_claim(sd_lcm_t *self, sd_claim_t claim) {
    const sixdeg_claim_t m = { (int32_t)claim.id, (int32_t)claim.signature };
    PUBLISH(self, SD_LCM_CLAIM, sixdeg_claim_t, &m);
}

void sd_lcm_truth(sd_lcm_t *self, const sd_truth_t *truth) {
    sd_lcm_codec_t *c = &self->codec;
    const sd_truth_edge_t *e = &truth->edge;
    const sd_truth_cycle_t *y = &truth->cycle;
    if (truth->kind == SD_TRUTH_EDGE) {
        c->truth_edge[c->truth_edges++] = (sixdeg_truth_edge_t){ e->time_s, e->angle_deg, e->crank_deg, e->speed_radps, e->net_torque_nm,
                                                                 (int32_t)e->tick, (int8_t)e->tooth, (int8_t)e->flags };
    } else if (truth->kind == SD_TRUTH_CYCLE) {
        c->truth_cycle[c->truth_cycles++] =
            (sixdeg_truth_cycle_t){ y->torque_nm, y->imep_pa, y->tdc_time_s, y->exhaust_lambda, y->cycle, (int8_t)y->cylinder,
                                                                    (int8_t)y->misfire };
    }
    const int full = (c->truth_edges == SD_LCM_ROWS) || (c->truth_cycles == SD_LCM_ROWS);
    if (full || (truth->kind == SD_TRUTH_END)) { publish_truth(self, truth->kind == SD_TRUTH_END); }
}

/* ---- in -------------------------------------------------------------------------------------------------------- */

int sd_lcm_wait(sd_lcm_t *self, int milliseconds) { return lcm_handle_timeout(self->lcm, milliseconds) > 0; }

static uint32_t receive_events(void *context, sd_event_t *events, uint32_t room) {
    sd_lcm_t *self = context;
    for (int m = 0; (m < MESSAGES_A_READ) && (self->codec.in.read == self->codec.in.written) && sd_lcm_wait(self, 0); ++m) {}
    return sd_queue_take(&self->codec.in, events, room);
}

sd_port_t sd_lcm_port(sd_lcm_t *self) { return (sd_port_t){ self, receive_events, send_events }; }
