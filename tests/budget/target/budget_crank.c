/* SPDX-License-Identifier: MIT */
/* The decoder alone, on edges that no golden run has: starts and faults of a wheel with one mark and of one with four, under jitter
 * and without. */
#include "board.h"
#include "budget_blocks.h"
#include "sd_crank.h"

enum { REGULAR, FAULT, SEARCHING, SYNC, PER_WHEEL }; /* of an edge: how the class begins at that wheel's first one */
enum { REVOLUTIONS = 16, STARTS = 60 };
#define SPACING 1000 /* ticks, before ripple */

static uint32_t chance_state = 1u;

static uint32_t chance(uint32_t of) {
    chance_state = chance_state * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)chance_state * of) >> 32);
}

static int is_missing(const sd_crank_config_t *wheel, uint32_t position) {
    for (uint32_t i = 0; i < wheel->missing_count; i++) {
        if (wheel->missing[i] == position) { return 1; }
    }
    return 0;
}

/* One edge, and what it was. */
static void take(sd_crank_t *crank, uint32_t tick, uint32_t first_class) {
    const uint32_t gains = crank->counts.sync_gains, losses = crank->counts.sync_losses;
    sd_tooth_t tooth;
    budget_class(0);
    sd_crank_edge(crank, tick, &tooth);
    const uint32_t what = (crank->counts.sync_gains != gains)              ? (uint32_t)SYNC
                          : (crank->counts.sync_losses != losses)           ? (uint32_t)FAULT
                          : (tooth.edge_class == (uint8_t)SD_EDGE_UNSYNCED) ? (uint32_t)SEARCHING
                          : (tooth.edge_class != (uint8_t)SD_EDGE_TOOTH)    ? (uint32_t)FAULT
                                                                            : (uint32_t)REGULAR;
    budget_class(first_class + what);
}

/* Starts at a tooth of the wheel by chance. jitter: each edge is off by up to so many ticks; faulty: one tooth in 50 is lost, one more
 * edge comes in 50, two in a row as often as one. */
static void start(const sd_crank_config_t *wheel, uint32_t first_class, uint32_t jitter, int faulty) {
    sd_crank_t crank;
    uint32_t tick = 1000u, position = chance(wheel->positions), lost = 0;
    (void)sd_crank_init(&crank, wheel);
    for (uint32_t k = 0; k < (uint32_t)REVOLUTIONS * wheel->positions; k++) {
        const uint32_t swing = (k * 60u / wheel->positions) % 30u, ripple = (swing < 15u) ? swing : 30u - swing; /* twice a revolution */
        const uint32_t pitch = SPACING * (100u + ripple) / 100u;
        tick += pitch;
        position = (position + 1u < wheel->positions) ? position + 1u : 0u;
        if (faulty && (chance(50u) == 0u)) { lost = 1u + chance(2u); }
        if (lost > 0u) { lost--; continue; }
        if (!is_missing(wheel, position)) { take(&crank, tick + chance(2u * jitter + 1u) - jitter, first_class); }
        if (!faulty || (chance(50u) != 0u)) { continue; }
        take(&crank, tick + pitch / 4u + chance(pitch / 5u), first_class);
        if (chance(2u) == 0u) { take(&crank, tick + pitch / 2u + chance(pitch / 5u), first_class); }
    }
}

void budget_count_crank(uint32_t first_class) {
    const sd_crank_config_t one = { .positions = 60, .missing_count = 2, .missing = { 58, 59 }, .stall_ticks = 1u << 20 };
    const sd_crank_config_t four = { .positions = 120, .missing_count = 9, .missing = { 28, 29, 57, 58, 59, 88, 89, 118, 119 },
                                     .stall_ticks = 1u << 20 };
    for (uint32_t i = 0; i < STARTS; i++) {
        const uint32_t jitter = (i % 3u) * SPACING / 10u; /* sd 0, 6 and 12 % */
        start(&one, first_class, jitter, (i % 2u) != 0u);
        start(&four, first_class + PER_WHEEL, jitter, (i % 2u) != 0u);
    }
}
