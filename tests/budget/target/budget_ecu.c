/* SPDX-License-Identifier: MIT */
/* A golden run on the target: the events that the emulator has loaded, one by one through sd_ecu_run, as a tooth interrupt
 * would. After each the plugin is told what it was; at the end stand a hash of all outputs and the stack used. */
#include "board.h"
#include "output_hash.h"
#include "sd_scaled.h"
#include "sd_ecu.h"

#define SENT_MAX     256u
#define SETTLED_CYCLES 11u /* Longer than any block takes to settle. */

_Static_assert(sizeof(sd_ecu_t) <= 16384u, "an ecu takes more RAM than there is for it");
static sd_ecu_t ecu;

/* ---- the port: one event waits, what is sent is kept ------------------------------------------------------------ */

static const sd_event_t *waiting;
static sd_event_t sent[SENT_MAX];
static uint32_t sent_count;

static uint32_t receive(void *context, sd_event_t *events, uint32_t room) {
    (void)context, (void)room;
    if (waiting == 0) { return 0u; }
    *events = *waiting;
    waiting = 0;
    return 1u;
}

static uint32_t send(void *context, const sd_event_t *events, uint32_t count) {
    (void)context;
    if (sent_count + count > SENT_MAX) { sent_count = SENT_MAX + 1u; return count; } /* said in the end */
    sd_event_t *to = &sent[sent_count];
    sent_count += count;
    for (uint32_t i = 0; i < count; i++) { to[i] = events[i]; }
    return count;
}

static const sd_port_t port = { 0, receive, send };
/* Not inlined, since its calls are counted. */
static uint32_t (*volatile run)(sd_ecu_t *, const sd_calibration_t *, const sd_port_t *) = sd_ecu_run;

/* ---- classes ------------------------------------------------------------------------------------------------------ */

/* What the last event made the ecu say. */
typedef struct said {
    uint32_t edge_class, tooth;
    uint8_t has_edge, has_firing, has_cycle;
} said_t;

/* By integers, so that the image of an ecu of fixed point has no floating-point arithmetic either. */
static uint32_t as_whole(uint32_t bits) { return sd_scaled_floor(sd_scaled_of(sd_of_bits(bits))); }

static said_t what_was_said(uint64_t *hash) {
    said_t said = { 0 };
    for (uint32_t i = 0; i < sent_count; i++) {
        const sd_event_t *event = &sent[i % SENT_MAX];
        *hash = sd_output_hash(*hash, event);
        if (event->kind != SD_EVENT_SIGNAL) { continue; }
        if (event->channel == SD_SIGNAL_CRANK_EDGE_CLASS) { said.edge_class = as_whole(event->value), said.has_edge = 1; }
        if (event->channel == SD_SIGNAL_CRANK_TOOTH) { said.tooth = as_whole(event->value); }
        if (event->channel == SD_SIGNAL_FIRING_TORQUE) { said.has_firing = 1; }
        if (event->channel == SD_SIGNAL_CYCLE_SPEED) { said.has_cycle = 1; }
    }
    return said;
}

static uint32_t class_of_edge(const said_t *said) {
    static uint32_t cycles;
    static uint32_t last_tooth;
    if (said->edge_class == (uint32_t)SD_EDGE_UNSYNCED) { cycles = 0; return CLASS_SEARCHING; }
    if (said->edge_class == (uint32_t)SD_EDGE_SPURIOUS) { return CLASS_SPURIOUS; }
    const int over_mark = (said->tooth != last_tooth + 1u); /* position 0 is the first tooth behind the mark */
    last_tooth = said->tooth;
    cycles += said->has_cycle;
    if (said->edge_class == (uint32_t)SD_EDGE_COASTED) { return CLASS_COASTED; }
    if (cycles < SETTLED_CYCLES) { return CLASS_STARTING; }
    if (said->has_cycle != 0u) { return CLASS_CYCLE_END; }
    if (over_mark) { return (said->has_firing != 0u) ? CLASS_MARK_FIRING : CLASS_MARK; }
    return (said->has_firing != 0u) ? CLASS_FIRING : CLASS_REGULAR;
}

static uint32_t class_of(const sd_event_t *event, const said_t *said) {
    switch (event->kind) {
    case SD_EVENT_CRANK_EDGE: return class_of_edge(said);
    case SD_EVENT_CAM_EDGE:   return CLASS_CAM;
    case SD_EVENT_TIME:       return CLASS_CLOCK;
    case SD_EVENT_SAMPLE:     return (event->channel == SD_INPUT_EXHAUST_LAMBDA) ? CLASS_LAMBDA : CLASS_SAMPLE;
    default:                  return CLASS_OTHER;
    }
}

/* ---- the run ------------------------------------------------------------------------------------------------------ */

int main(void) {
    const board_header_t *header = BOARD_EVENTS;
    const sd_event_t *events = (const sd_event_t *)(header + 1);
    uint64_t hash = SD_OUTPUT_HASH_START;
    const sd_calibration_t *page = sd_calibration_view(BOARD_PAGE, header->page_bytes);
    if (page == 0) { board_print("the page was refused\n"); return 1; }
    board_paint_stack();
    if (sd_ecu_init(&ecu, page) != SD_OK) { board_print("init refused the page\n"); return 2; }
    board_figure("stack_init", board_stack_used());
    board_paint_stack();
    budget_class(CLASS_SETUP);
    for (uint32_t i = 0; i < header->event_count; i++) {
        waiting = &events[i];
        sent_count = 0;
        (void)run(&ecu, page, &port);
        const said_t said = what_was_said(&hash);
        if (sent_count > SENT_MAX) { board_print("more was sent than is kept\n"); return 3; }
        budget_class(class_of(&events[i], &said));
    }
    board_figure("stack_run", board_stack_used());
    board_figure("hash", hash);
    return 0;
}
