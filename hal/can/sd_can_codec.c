/* SPDX-License-Identifier: MIT */
#include "sd_can_codec.h"

#include "sd_bus_rows.h"

_Static_assert(SD_BUS_TRUTH_EDGE_FRAME_ID == SD_CAN_TRUTH_FIRST, "the filter of an ecu must hold what sixdeg.dbc says");

enum { CRANK = 0, CAM = 1, FIRST_WHEEL = 2 }; /* what a tick of a teeth frame is an edge of */

static uint32_t room(const sd_can_codec_t *self) { return SD_CAN_FRAMES - (self->written - self->read); }

static sd_frame_t *next_frame(sd_can_codec_t *self, uint32_t id, int fd) {
    sd_frame_t *frame = &self->out[self->written++ % SD_CAN_FRAMES];
    frame->id = id;
    frame->fd = (uint8_t)fd;
    return frame;
}

/* ---- events to frames ------------------------------------------------------------------------------------------ */

#define PACK(self, name, NAME, fd, message)                                                                            \
    do {                                                                                                               \
        sd_frame_t *frame = next_frame(self, SD_BUS_##NAME##_FRAME_ID, fd);                                            \
        frame->length = SD_BUS_##NAME##_LENGTH;                                                                        \
        (void)sd_bus_##name##_pack(frame->bytes, &(message), sizeof frame->bytes);                                     \
    } while (0)

_Static_assert(offsetof(struct sd_bus_teeth_t, tick_12) - offsetof(struct sd_bus_teeth_t, tick_0) == 4u * (SD_CAN_TEETH - 1u),
               "ticks of a teeth frame lie in a row");
_Static_assert(offsetof(struct sd_bus_teeth_t, edge_12) - offsetof(struct sd_bus_teeth_t, edge_0) == SD_CAN_TEETH - 1u,
               "and so do their wheels");

static void send_teeth(sd_can_codec_t *self) {
    if (self->ticks == 0u) { return; }
    struct sd_bus_teeth_t m = { .sequence = self->sequence++, .session = self->session, .count = self->ticks };
    memcpy(&m.tick_0, self->tick, sizeof self->tick);
    memcpy(&m.edge_0, self->edge, sizeof self->edge);
    PACK(self, teeth, TEETH, 1, m);
    self->ticks = 0;
    memset(self->edge, 0, sizeof self->edge);
}

static void add_edge(sd_can_codec_t *self, const sd_event_t *event) {
    const int wheel = event->kind == SD_EVENT_WHEEL_EDGE;
    if (wheel && (event->channel >= SD_BUS_WHEELS)) { self->counts.unsent++; return; }
    self->edge[self->ticks] = wheel ? (uint8_t)(FIRST_WHEEL + event->channel) : (event->kind == SD_EVENT_CAM_EDGE) ? CAM : CRANK;
    self->tick[self->ticks++] = event->tick;
    if (self->ticks == SD_CAN_TEETH) { send_teeth(self); }
}

static void send_sample(sd_can_codec_t *self, const sd_event_t *event) {
    sd_frame_t *frame = next_frame(self, SD_BUS_INPUTS_FIRST + event->channel, 0);
    frame->length = 8;
    for (uint32_t i = 0; i < 4u; ++i) {
        frame->bytes[i] = (uint8_t)(event->tick >> (8u * i));
        frame->bytes[4u + i] = (uint8_t)(event->value >> (8u * i));
    }
}

static void send_time(sd_can_codec_t *self, const sd_event_t *event) {
    const struct sd_bus_time_t m = { .tick = event->tick, .sequence = self->sequence, .session = self->session };
    PACK(self, time, TIME, 0, m);
}

static void send_done(sd_can_codec_t *self, const sd_event_t *event) {
    const struct sd_bus_done_t m = { .tick = event->tick, .ignored = (uint8_t)event->flags, .session = self->session,
                                     .unsent = (uint8_t)event->value };
    PACK(self, done, DONE, 0, m);
}

static void send_row(sd_can_codec_t *self, const sd_event_t *event) {
    const sd_row_t *row = sd_row_take(self->row, event);
    if (row == NULL) { return; }
    uint8_t bytes[64];
    uint32_t id = 0, length;
    for (uint32_t part = 0; (length = sd_bus_row_pack(row, part, &id, bytes)) != 0u; ++part) {
        sd_frame_t *frame = next_frame(self, id, 1);
        frame->length = (uint8_t)length;
        memcpy(frame->bytes, bytes, sizeof bytes);
    }
}

static void send_parameter(sd_can_codec_t *self, const sd_event_t *event) {
    float value;
    memcpy(&value, &event->value, sizeof value);
    const uint8_t command = (uint8_t)(event->flags & 0xffu), index = (uint8_t)event->channel;
    if (self->role == SD_ROLE_ECU) {
        const struct sd_bus_parameter_t m = { .command = command, .index = index, .value = value,
                                              .result = (uint8_t)(event->flags >> 8) };
        PACK(self, parameter, PARAMETER, 0, m);
    } else {
        const struct sd_bus_parameter_request_t m = { .command = command, .index = index, .value = value };
        PACK(self, parameter_request, PARAMETER_REQUEST, 0, m);
    }
}

#define FRAMES_AN_EVENT (SD_BUS_ROW_FRAMES + 1u) /* at most: those of a row, behind teeth that waited */

int sd_can_encode(sd_can_codec_t *self, const sd_event_t *event) {
    if (room(self) < FRAMES_AN_EVENT) { return 0; }
    const int edge = (event->kind == SD_EVENT_CRANK_EDGE) || (event->kind == SD_EVENT_CAM_EDGE) || (event->kind == SD_EVENT_WHEEL_EDGE);
    if (!edge) { send_teeth(self); } /* nothing overtakes an edge */
    switch (event->kind) {
    case SD_EVENT_CRANK_EDGE:
    case SD_EVENT_WHEEL_EDGE:
    case SD_EVENT_CAM_EDGE:  add_edge(self, event); break;
    case SD_EVENT_SAMPLE:    send_sample(self, event); break;
    case SD_EVENT_TIME:      send_time(self, event); break;
    case SD_EVENT_SIGNAL:    send_row(self, event); break;
    case SD_EVENT_DONE:      send_done(self, event); break;
    case SD_EVENT_PARAMETER: send_parameter(self, event); break;
    default: break;
    }
    return 1;
}

int sd_can_encode_truth(sd_can_codec_t *self, const sd_truth_t *truth) {
    if (room(self) == 0u) { return 0; }
    const sd_truth_edge_t *e = &truth->edge;
    const sd_truth_cycle_t *c = &truth->cycle;
    if (truth->kind == SD_TRUTH_EDGE) {
        const struct sd_bus_truth_edge_t m = { e->time_s, e->angle_deg, e->crank_deg, e->speed_radps, e->net_torque_nm,
                                               e->tick, e->tooth, e->flags };
        PACK(self, truth_edge, TRUTH_EDGE, 1, m);
    } else if (truth->kind == SD_TRUTH_CYCLE) {
        const struct sd_bus_truth_cycle_t m =
            { c->torque_nm, c->imep_pa, c->tdc_time_s, c->exhaust_lambda, c->cycle, c->cylinder, c->misfire };
        PACK(self, truth_cycle, TRUTH_CYCLE, 1, m);
    } else {
        const struct sd_bus_truth_end_t m = { truth->end.edges, truth->end.cycles };
        PACK(self, truth_end, TRUTH_END, 0, m);
    }
    return 1;
}

int sd_can_encode_claim(sd_can_codec_t *self, sd_claim_t claim) {
    if (room(self) == 0u) { return 0; }
    const struct sd_bus_claim_t m = { claim.id, claim.signature };
    PACK(self, claim, CLAIM, 0, m);
    return 1;
}

/* ---- frames to events ------------------------------------------------------------------------------------------ */

static void put(sd_can_codec_t *self, uint32_t tick, sd_event_kind_t kind, uint16_t channel, float value, uint32_t flags) {
    sd_event_t event = { .tick = tick, .kind = (uint16_t)kind, .channel = channel, .flags = flags };
    memcpy(&event.value, &value, sizeof event.value);
    sd_queue_put(&self->in, &event);
}

/* 1: in order, or after a gap that the ecu has been told of. */
static int arrives(sd_can_codec_t *self, uint16_t session, uint16_t sequence, uint16_t step, uint32_t tick) {
    const sd_arrival_t arrival = sd_order_check(&self->order, session, sequence, step);
    if (arrival == SD_ARRIVAL_STALE) { self->counts.stale++; return 0; }
    if (arrival == SD_ARRIVAL_GAP) {
        self->counts.gaps++;
        put(self, tick, SD_EVENT_GAP, 0, 0.0f, 0);
    }
    return 1;
}

static int take_teeth(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_teeth_t m;
    if ((frame->length != SD_BUS_TEETH_LENGTH) || (sd_bus_teeth_unpack(&m, frame->bytes, frame->length) != 0)) { return 0; }
    if ((m.count == 0u) || (m.count > SD_CAN_TEETH)) { return 0; }
    uint32_t tick[SD_CAN_TEETH];
    uint8_t edge[SD_CAN_TEETH];
    memcpy(tick, &m.tick_0, sizeof tick);
    memcpy(edge, &m.edge_0, sizeof edge);
    if (!arrives(self, m.session, m.sequence, 1, tick[0])) { return 1; }
    for (uint32_t i = 0; i < m.count; ++i) {
        const int wheel = edge[i] >= FIRST_WHEEL;
        const sd_event_kind_t kind = wheel ? SD_EVENT_WHEEL_EDGE : (edge[i] == CAM) ? SD_EVENT_CAM_EDGE : SD_EVENT_CRANK_EDGE;
        put(self, tick[i], kind, (uint16_t)(wheel ? edge[i] - FIRST_WHEEL : 0), 0.0f, 0);
    }
    return 1;
}

static int take_time(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_time_t m;
    if ((frame->length != 8u) || (sd_bus_time_unpack(&m, frame->bytes, 8) != 0)) { return 0; }
    if (arrives(self, m.session, m.sequence, 0, m.tick)) { put(self, m.tick, SD_EVENT_TIME, 0, 0.0f, 0); }
    return 1;
}

static int take_sample(sd_can_codec_t *self, const sd_frame_t *frame) {
    if (frame->length != 8u) { return 0; }
    sd_event_t event = { .kind = SD_EVENT_SAMPLE, .channel = (uint16_t)(frame->id - SD_BUS_INPUTS_FIRST) };
    for (uint32_t i = 0; i < 4u; ++i) {
        event.tick |= (uint32_t)frame->bytes[i] << (8u * i);
        event.value |= (uint32_t)frame->bytes[4u + i] << (8u * i);
    }
    sd_queue_put(&self->in, &event);
    return 1;
}

static int take_done(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_done_t m;
    if ((frame->length != 8u) || (sd_bus_done_unpack(&m, frame->bytes, 8) != 0)) { return 0; }
    if ((self->peer_seen != 0u) && (m.session != self->peer_session)) { self->peer_starts++; }
    self->peer_seen = 1;
    self->peer_session = m.session;
    const sd_event_t event = { .tick = m.tick, .kind = SD_EVENT_DONE, .value = m.unsent, .flags = m.ignored };
    sd_queue_put(&self->in, &event);
    return 1;
}

static int take_request(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_parameter_request_t m;
    if ((frame->length != 8u) || (sd_bus_parameter_request_unpack(&m, frame->bytes, 8) != 0)) { return 0; }
    put(self, 0, SD_EVENT_PARAMETER, m.index, m.value, m.command);
    return 1;
}

static int take_parameter(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_parameter_t m;
    if ((frame->length != 8u) || (sd_bus_parameter_unpack(&m, frame->bytes, 8) != 0)) { return 0; }
    put(self, 0, SD_EVENT_PARAMETER, m.index, m.value, m.command | ((uint32_t)m.result << 8));
    return 1;
}

static int take_claim(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_claim_t m;
    if ((frame->length != 8u) || (sd_bus_claim_unpack(&m, frame->bytes, 8) != 0)) { return 0; }
    self->claim = (sd_claim_t){ m.id, m.signature };
    self->claim_heard = 1;
    return 1;
}

static int take_row(sd_can_codec_t *self, const sd_frame_t *frame) {
    sd_row_t row;
    return (sd_bus_row_unpack(&row, frame->id, frame->bytes, frame->length) == 1) && sd_row_events(&row, &self->in);
}

static int take_truth(sd_can_codec_t *self, const sd_frame_t *frame) {
    struct sd_bus_truth_edge_t e;
    struct sd_bus_truth_cycle_t c;
    struct sd_bus_truth_end_t n;
    if ((frame->id == SD_BUS_TRUTH_EDGE_FRAME_ID) && (frame->length == SD_BUS_TRUTH_EDGE_LENGTH)) {
        (void)sd_bus_truth_edge_unpack(&e, frame->bytes, frame->length);
        self->truth.kind = SD_TRUTH_EDGE;
        self->truth.edge = (sd_truth_edge_t){ e.time_s, e.angle_deg, e.crank_deg, e.speed_radps, e.net_torque_nm, e.tick,
                                              e.tooth, e.flags };
    } else if ((frame->id == SD_BUS_TRUTH_CYCLE_FRAME_ID) && (frame->length == SD_BUS_TRUTH_CYCLE_LENGTH)) {
        (void)sd_bus_truth_cycle_unpack(&c, frame->bytes, frame->length);
        self->truth.kind = SD_TRUTH_CYCLE;
        self->truth.cycle = (sd_truth_cycle_t){ c.torque_nm, c.imep_pa, c.tdc_time_s, c.exhaust_lambda, c.cycle, c.cylinder, c.misfire };
    } else if ((frame->id == SD_BUS_TRUTH_END_FRAME_ID) && (frame->length == SD_BUS_TRUTH_END_LENGTH)) {
        (void)sd_bus_truth_end_unpack(&n, frame->bytes, frame->length);
        self->truth.kind = SD_TRUTH_END;
        self->truth.end = (sd_truth_end_t){ n.edges, n.cycles };
    } else {
        return 0;
    }
    return 1;
}

/* 1 taken, 0 malformed, -1 not for this role. */
static int take(sd_can_codec_t *self, const sd_frame_t *frame) {
    const int ecu = self->role == SD_ROLE_ECU, tool = self->role == SD_ROLE_TOOL;
    switch (frame->id) {
    case SD_BUS_CLAIM_FRAME_ID:             return take_claim(self, frame);
    case SD_BUS_TEETH_FRAME_ID:             return ecu ? take_teeth(self, frame) : -1;
    case SD_BUS_TIME_FRAME_ID:              return ecu ? take_time(self, frame) : -1;
    case SD_BUS_PARAMETER_REQUEST_FRAME_ID: return ecu ? take_request(self, frame) : -1;
    case SD_BUS_DONE_FRAME_ID:              return ecu ? -1 : take_done(self, frame);
    case SD_BUS_PARAMETER_FRAME_ID:         return tool ? take_parameter(self, frame) : -1;
    default: break;
    }
    if ((frame->id >= SD_BUS_INPUTS_FIRST) && (frame->id < SD_BUS_INPUTS_END)) { return ecu ? take_sample(self, frame) : -1; }
    return ecu ? -1 : take_row(self, frame);
}

static int is_ours(uint32_t id) {
    sd_row_t row;
    return ((id >= SD_BUS_TEETH_FRAME_ID) && (id <= SD_BUS_TIME_FRAME_ID)) || ((id >= SD_BUS_INPUTS_FIRST) && (id < SD_BUS_INPUTS_END)) ||
           (id == SD_BUS_DONE_FRAME_ID) || ((id >= SD_BUS_PARAMETER_REQUEST_FRAME_ID) && (id <= SD_BUS_CLAIM_FRAME_ID)) ||
           ((id >= SD_CAN_TRUTH_FIRST) && (id <= SD_BUS_TRUTH_END_FRAME_ID)) || (sd_bus_row_unpack(&row, id, NULL, 0) != 0);
}

int sd_can_decode(sd_can_codec_t *self, const sd_frame_t *frame) {
    if (!is_ours(frame->id)) { self->counts.foreign++; return 0; }
    self->counts.received++;
    if (frame->id >= SD_CAN_TRUTH_FIRST) {
        if (self->role != SD_ROLE_TOOL) { return 0; }
        if (take_truth(self, frame)) { return 1; }
        self->counts.malformed++;
        return 0;
    }
    if (take(self, frame) == 0) { self->counts.malformed++; }
    return 0;
}
