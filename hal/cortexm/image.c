/* SPDX-License-Identifier: MIT */
/* The firmware on a controller: the ecu behind interrupts, with a page that is read in flash, where it lies.
 *
 * In this image the host stands for the engine (sd_link.h): an event that it names makes the interrupt due that such an event makes due
 * on a board, and the next one follows when it has been handled. */
#include "bench.h"
#include "sd_board.h"
#include "sd_cortexm.h"
#include "sd_ecu.h"
#include "sd_link.h"

#define SAID_BYTES 65536u /* of frames, before they are handed to the host */
#define SAID_ROOM  8192u  /* more than the frame of one event takes */

static sd_ecu_t ecu;
static const sd_calibration_t *page;
static sd_cortexm_t port;
static int32_t host_says, host_hears;

/* ---- what the ecu says goes into frames ----------------------------------------------------------------------------- */

static uint8_t said[SAID_BYTES];
static uint32_t said_bytes;
static sd_link_frame_t frame;
static sd_event_t *frame_events;

static void hand_over(void) {
    if (board_write(host_hears, said, said_bytes) != 0u) { board_exit(0u); } /* nobody listens any more */
    said_bytes = 0;
}

static void put(const void *from, uint32_t bytes) {
    const uint8_t *byte = from;
    for (uint32_t i = 0; i < bytes; i++) { said[said_bytes + i] = byte[i]; }
    said_bytes += bytes;
}

static uint32_t send(void *context, const sd_event_t *events, uint32_t count) {
    (void)context;
    const uint32_t room = (uint32_t)(&said[SAID_BYTES] - (const uint8_t *)&frame_events[frame.count]) / (uint32_t)sizeof *events;
    const uint32_t taken = (count < room) ? count : room;
    for (uint32_t i = 0; i < taken; i++) { frame_events[frame.count + i] = events[i]; }
    frame.count += taken;
    return taken;
}

/* ---- the interrupts ------------------------------------------------------------------------------------------------- */

static sd_event_t captured; /* by the capture timer, by the converter, or by the clock: what made the interrupt due */
static volatile uint32_t handled, nested, interrupted, task_ticks;
static volatile uint8_t working, tasking;
static uint8_t waiting;

static void on_edge(const sd_event_t *edge) {
    nested += working;
    sd_cortexm_edge(&port, (sd_event_kind_t)edge->kind, edge->tick);
    board_pend(BOARD_IRQ_WORK);
}

static void on_other(const sd_event_t *event) {
    sd_cortexm_post(&port, event);
    board_pend(BOARD_IRQ_WORK);
}

void board_on_capture(void) {
    if (bench_count() != 0u) { bench_capture(on_edge); } else { on_edge(&captured); }
}

void board_on_sample(void) { on_other(&captured); }

/* Every 10 ms; on a board it reads the slow sensors first. */
void board_on_clock(void) {
    if (bench_count() != 0u) { bench_task(on_other); } else { on_other(&captured); }
}

static uint32_t receive(void *context, sd_event_t *events, uint32_t room) {
    (void)context, (void)room;
    if (waiting == 0u) { return 0u; }
    waiting = 0;
    *events = frame.in;
    return 1u;
}

static const sd_port_t ports = { 0, receive, send };

static uint32_t ticks_since(uint32_t before) { return (before - board_ticks()) & 0x00FFFFFFu; } /* the core's timer counts down */

/* The host's clock event has one frame, whatever of its task is put off. */
static bool opens_frame(void) { return (bench_count() != 0u) || (frame.in.kind != (uint16_t)SD_EVENT_TASK); }
static bool closes_frame(void) { return (bench_count() != 0u) || (frame.in.kind != (uint16_t)SD_EVENT_TIME); }

static void open_frame(void) {
    if (said_bytes + SAID_ROOM > SAID_BYTES) { hand_over(); }
    frame_events = (sd_event_t *)(void *)&said[said_bytes + sizeof frame];
    frame.count = frame.ticks = 0;
}

static void close_frame(void) {
    if (!opens_frame()) { frame.in = captured, frame.ticks += task_ticks; }
    put(&frame, sizeof frame);
    said_bytes += frame.count * (uint32_t)sizeof(sd_event_t);
    frame.count = 0;
    handled++;
}

void board_on_work(void) {
    working = 1;
    while (sd_cortexm_next(&port, &frame.in)) {
        if (opens_frame()) { open_frame(); }
        waiting = 1;
        const uint32_t before = board_ticks();
        (void)sd_ecu_run(&ecu, page, &ports);
        frame.ticks += ticks_since(before);
        if (closes_frame()) { close_frame(); }
        if (frame.in.kind == (uint16_t)SD_EVENT_CRANK_EDGE) {
            interrupted += tasking;
            bench_handled(frame.in.tick);
        }
    }
    working = 0;
    if (sd_cortexm_task_due(&port) && (tasking == 0u)) { board_pend(BOARD_IRQ_TASK); }
}

/* The last priority: teeth interrupt it. */
void board_on_task(void) {
    tasking = 1;
    const uint32_t before = board_ticks();
    sd_ecu_task_run(&ecu, page);
    task_ticks = ticks_since(before);
    sd_cortexm_task_done(&port);
    tasking = 0;
    board_pend(BOARD_IRQ_WORK);
}

/* ---- the program ---------------------------------------------------------------------------------------------------- */

static uint32_t irq_of(uint32_t kind) {
    if ((kind == (uint32_t)SD_EVENT_CRANK_EDGE) || (kind == (uint32_t)SD_EVENT_CAM_EDGE)) { return BOARD_IRQ_CAPTURE; }
    return (kind == (uint32_t)SD_EVENT_TIME) ? BOARD_IRQ_CLOCK : BOARD_IRQ_SAMPLE;
}

static void happen(const sd_event_t *event) {
    const uint32_t before = handled;
    captured = *event;
    board_pend(irq_of(event->kind));
    while (handled == before) {} /* every interrupt goes before this program */
}

static void serve(void) {
    static sd_event_t asked[SD_LINK_EVENTS];
    uint32_t count;
    while ((board_read(host_says, &count, sizeof count) == 0u) && (count != 0u)) {
        if ((count > SD_LINK_EVENTS) || (board_read(host_says, asked, count * (uint32_t)sizeof asked[0]) != 0u)) { return; }
        for (uint32_t i = 0; i < count; i++) { happen(&asked[i]); }
        hand_over();
    }
}

static void say_end(void) {
    const sd_link_frame_t last = { .count = SD_LINK_LAST };
    const sd_link_end_t end = { .stack_bytes = board_stack_used(), .overruns = port.overruns, .lost_edges = port.lost_edges,
                                .lost_others = port.lost_others, .longest = bench_longest(), .nested = nested,
                                .interrupted = interrupted, .tasks_late = port.tasks_late };
    put(&last, sizeof last);
    put(&end, sizeof end);
    hand_over();
}

static sd_link_state_t start(void) {
    const sd_page_head_t *head = (const sd_page_head_t *)(const void *)BOARD_PAGE;
    page = (head->bytes <= BOARD_PAGE_ROOM) ? sd_calibration_view(BOARD_PAGE, head->bytes) : 0;
    if (page == 0) { return SD_LINK_PAGE_REFUSED; }
    if (sd_ecu_init(&ecu, page) != SD_OK) { return SD_LINK_INIT_REFUSED; }
    sd_cortexm_init(&port);
    board_start_ticks();
    board_enable(BOARD_IRQ_CAPTURE, 0);
    board_enable(BOARD_IRQ_WORK, 1);
    board_enable(BOARD_IRQ_CLOCK, 2);
    board_enable(BOARD_IRQ_SAMPLE, 2);
    board_enable(BOARD_IRQ_TASK, 3);
    return SD_LINK_READY;
}

int main(void) {
    host_says = board_open("/dev/stdin", 0);
    host_hears = board_open("/dev/stdout", 1);
    if ((host_says < 0) || (host_hears < 0)) { board_print("the host's standard input and output cannot be opened\n"); return 3; }
    board_paint_stack();
    const sd_link_hello_t hello = { .magic = SD_LINK_MAGIC, .signature = SD_SIGNALS_SIGNATURE, .state = (uint32_t)start(),
                                    .ecu_bytes = (uint32_t)sizeof ecu };
    put(&hello, sizeof hello);
    hand_over();
    if (hello.state != (uint32_t)SD_LINK_READY) { return (int)hello.state; }
    if (bench_count() != 0u) { bench_run(); } else { serve(); }
    say_end();
    return 0;
}
