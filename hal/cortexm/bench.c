/* SPDX-License-Identifier: MIT */
#include "bench.h"

#include <stdbool.h>

#include "sd_board.h"

#define BOARD_TICK_NS 40u
#define BEFORE_FIRST  25000u /* ticks of 40 ns until the first event: 1 ms */

static volatile uint32_t due;   /* events that have happened */
static volatile uint32_t taken; /* of those, how far the task has come */
static uint32_t begun, longest;

static const board_header_t *header(void) { return BOARD_EVENTS; }
static const sd_event_t *event(uint32_t i) { return (const sd_event_t *)(const void *)(header() + 1) + i; }
uint32_t bench_count(void) { return header()->event_count; }
uint32_t bench_longest(void) { return longest; }

/* When a tick of the events is, on the board's timer. */
static uint32_t when(uint32_t tick) { return begun + (tick - event(0)->tick) * (header()->tick_ns / BOARD_TICK_NS); }

static bool is_edge(const sd_event_t *e) { return (e->kind == (uint16_t)SD_EVENT_CRANK_EDGE) || (e->kind == (uint16_t)SD_EVENT_CAM_EDGE); }

void bench_capture(bench_taker_t *edge) {
    board_capture_seen();
    bool other = false;
    while (due < bench_count()) {
        const sd_event_t *next = event(due);
        const int32_t left = (int32_t)(when(next->tick) - board_now());
        if (left > 0) {
            board_capture_after((uint32_t)left);
            break;
        }
        due++;
        if (is_edge(next)) { edge(next); } else { other = true; }
    }
    if (other) { board_pend(BOARD_IRQ_CLOCK); }
}

void bench_task(bench_taker_t *other) {
    while (taken < due) {
        const sd_event_t *next = event(taken);
        taken++;
        if (!is_edge(next)) { other(next); }
    }
}

void bench_handled(uint32_t tick) {
    if (bench_count() == 0u) { return; }
    const uint32_t took = board_now() - when(tick);
    if (took > longest) { longest = took; }
}

/* The program spins: under the emulator's counted instructions a core that waits for an interrupt would see other times. */
void bench_run(void) {
    begun = board_now() + BEFORE_FIRST;
    board_capture_after(BEFORE_FIRST);
    while ((due < bench_count()) || (taken < bench_count())) {
        if (due == bench_count()) { board_pend(BOARD_IRQ_CLOCK); } /* edges at the end leave it nothing to do */
    }
}
