/* SPDX-License-Identifier: MIT */
/* sd_crank_parts.h - what the files of the decoder share; not for use from outside. */
#ifndef SD_CRANK_PARTS_H
#define SD_CRANK_PARTS_H
#include "sd_crank.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ONE SD_SPACING_ONE

enum { WAITING, SEARCHING, TRYING, SYNCED }; /* sd_crank_t.mode */
enum { QUICK, MIDDLE, MEMORY, CALM };        /* sd_crank_t.clock */

enum {
    STALL_TICKS_MAX = 1 << 24,
    VOTE_AFTER      = 3,  /* teeth past the mark before the vote */
};

static inline int32_t abs32(int32_t x) { return (x < 0) ? -x : x; }
static inline int32_t clamp32(int64_t x, int32_t low, int32_t high) {
    return (x < low) ? low : (x > high) ? high : (int32_t)x;
}

/* ---- sd_crank_clock.c: when the next tooth comes ---- */

/* What a clock says of a way: how long it takes and the period at its end, 1/64 tick. */
typedef struct sd_forecast { int64_t time; int32_t period; } sd_forecast_t;

int64_t sd_clock_since(const sd_crank_clock_t *c, uint32_t tick);
sd_forecast_t sd_clock_forecast(const sd_crank_clock_t *c, uint32_t kind, const sd_crank_way_t *way);
int32_t sd_clock_lateness(const sd_forecast_t *ahead, int64_t elapsed);
uint8_t sd_clock_best(const sd_crank_t *self, uint32_t except);
void sd_clock_start(sd_crank_clock_t *c, uint32_t tick, uint32_t period_ticks);
int32_t sd_clock_place(sd_crank_clock_t *c, uint32_t kind, uint32_t tick, const sd_crank_way_t *way);
void sd_memory_forget(sd_crank_t *self);

/* ---- sd_crank_mark.c: where the teeth are, and whether the mark is where it should be ---- */

uint32_t sd_wheel_mark_after(const sd_crank_t *self, uint32_t position);
uint32_t sd_wheel_first_after(const sd_crank_t *self, uint32_t mark);
bool sd_wheel_second_after(const sd_crank_t *self);
void sd_wheel_sum_turn(sd_crank_t *self);
void sd_wheel_reset_widths(sd_crank_t *self);
int32_t sd_wheel_plausible_width(int64_t spacings);
bool sd_wheel_find_marks(sd_crank_t *self);
void sd_mark_vote(sd_crank_t *self);

#ifdef __cplusplus
}
#endif

#endif
