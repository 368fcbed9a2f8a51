/* SPDX-License-Identifier: MIT */
/* sd_crank_parts.h - what the files of the decoder share; not for use from outside. */
#ifndef SD_CRANK_PARTS_H
#define SD_CRANK_PARTS_H
#include "sd_crank.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ONE SD_SPACING_ONE
#define SD_INLINE static inline __attribute__((always_inline)) /* in the path of every tooth */

enum { WAITING, SEARCHING, SYNCED };  /* sd_crank_t.mode */
enum { QUICK, MEMORY, CALM }; /* sd_crank_clocks_t.clock */

enum {
    STALL_TICKS_MAX = 1 << 24,
    PERIOD_MIN      = 64,                   /* 1/64 tick */
    PERIOD_MAX      = (1 << 29) - 1,        /* slower than 2^23 ticks a spacing is not followed */
    TIME_MAX        = 1 << 30,              /* longest forecast, 1/64 tick */
    RATIO_MIN       = 1 << 8,               /* Q16 */
    RATIO_MAX       = 1 << 24,
    VOTE_AFTER      = 3,                    /* teeth past the mark before the vote */
    LOOSE           = (42 * ONE) / 100,     /* an edge further off is not this tooth */
    NOISY           = ONE / 24,             /* edges further from even than this, on average */
};

static inline int32_t abs32(int32_t x) { return (x < 0) ? (int32_t)(0u - (uint32_t)x) : x; }
static inline int32_t clamp_in(int32_t x, int32_t low, int32_t high) { return (x < low) ? low : (x > high) ? high : x; }
static inline int32_t clamp32(int64_t x, int32_t low, int32_t high) {
    return (x < low) ? low : (x > high) ? high : (int32_t)x;
}
/* Edges further off than this are flagged; further off than LOOSE they are left out. `error`: of the leading clock. */
static inline int32_t tight_gate(int32_t error) { return clamp_in(4 * error + (6 * ONE) / 100, (12 * ONE) / 100, LOOSE); }
static inline int32_t scale12(int32_t x, int32_t q12) { return (int32_t)(((int64_t)x * q12) >> 12); }
static inline uint32_t next_slot(const sd_crank_t *self, uint32_t slot) { return (slot + 1u < self->teeth) ? slot + 1u : 0u; }
static inline sd_crank_clocks_t *clocks_now(sd_crank_t *self) { return &self->clocks[self->now]; }
static inline const sd_crank_clock_t *leading(const sd_crank_t *self) {
    const sd_crank_clocks_t *clocks = &self->clocks[self->now];
    return &clocks->clock[clocks->leader];
}

/* One over a period: one division of 32 bits serves all quotients of a tooth. */
typedef struct sd_inverse {
    uint32_t scale, shift;
    int32_t  most;          /* longest time that can be divided, some four to eight periods */
    int32_t  period;
} sd_inverse_t;

/* a + b, and a - b, that wrap where they do not fit; the bounds that follow make of it what they may. */
SD_INLINE int32_t plus32(int32_t a, int32_t b) { return (int32_t)((uint32_t)a + (uint32_t)b); }
SD_INLINE int32_t minus32(int32_t a, int32_t b) { return (int32_t)((uint32_t)a - (uint32_t)b); }

/* Of a period within PERIOD_MIN / 2 to PERIOD_MAX, which is what a forecast may grow beyond. */
SD_INLINE sd_inverse_t sd_inverse_of(int32_t foretold) {
    const int32_t period = clamp_in(foretold, PERIOD_MIN / 2, PERIOD_MAX);
    const uint32_t up = (uint32_t)__builtin_clz((uint32_t)period);
    const uint32_t shift = up - 3u;
    return (sd_inverse_t){ 0x80000000u / (((uint32_t)period << up) >> 16), shift, 0x7FFFFFFF >> shift, period };
}
/* time / period, Q12, at most eight spacings either way. */
SD_INLINE int32_t sd_in_spacings(const sd_inverse_t *inverse, int32_t time) {
    const int32_t within = clamp_in(time, -inverse->most, inverse->most);
    return (int32_t)(((int64_t)(int32_t)((uint32_t)within << inverse->shift) * (int32_t)inverse->scale) >> 32);
}

/* ---- sd_crank_clock.c: when the next tooth comes ---- */

/* What a clock says of a way: how long it takes and the time of a spacing at its end, 1/64 tick. */
typedef struct sd_forecast { int32_t time, period; } sd_forecast_t;

/* Since the last placed edge by this clock, 1/64 tick. */
static inline int32_t sd_clock_since(const sd_crank_clock_t *clock, uint32_t tick) { return (int32_t)((tick << 6) - clock->time); }
SD_INLINE uint32_t sd_by_ratio(uint32_t recalled, uint32_t ratio) {
    const uint64_t time = ((uint64_t)recalled * ratio) >> 16;
    return (time < (uint32_t)TIME_MAX) ? (uint32_t)time : (uint32_t)TIME_MAX;
}
/* What the leading clock says of the next spacing, which took `recalled` in the memory. */
SD_INLINE int32_t sd_clock_next(const sd_crank_clocks_t *clocks, uint32_t recalled) {
    const uint32_t leader = clocks->leader;
    if (leader == MEMORY) { return clamp_in((int32_t)sd_by_ratio(recalled, clocks->ratio), PERIOD_MIN, PERIOD_MAX); }
    return clocks->clock[leader].period + clocks->clock[leader].change;
}
/* How late an edge is that the clock foretold `time` after the last one, 1/64 tick; wraps as ticks do. */
static inline int32_t sd_clock_late(const sd_crank_clock_t *clock, uint32_t tick, int32_t time) {
    return (int32_t)((tick << 6) - clock->time - (uint32_t)time);
}
sd_forecast_t sd_clock_forecast(const sd_crank_clocks_t *clocks, uint32_t kind, const sd_crank_way_t *way);
uint32_t sd_clock_best(const sd_crank_clocks_t *clocks, uint32_t except);
void sd_clocks_move(sd_crank_t *self, uint32_t tick, bool clean, const sd_inverse_t *inverse);
void sd_clocks_move_far(sd_crank_t *self, uint32_t tick, bool clean, const sd_inverse_t *inverse);

/* ---- sd_crank_memory.c: how clocks and memory begin ---- */

void sd_clocks_start(sd_crank_t *self, uint32_t tick, int32_t period, int32_t change);
void sd_clocks_recall(sd_crank_t *self, uint32_t tick, uint32_t noise_q12, uint32_t uneven_q12);
void sd_memory_forget(sd_crank_t *self);
void sd_memory_fill(sd_crank_t *self, uint32_t steps, uint32_t period_ticks);

/* ---- sd_crank_wheel.c: the teeth and the marks between them ---- */

bool sd_wheel_init(sd_crank_t *self);
/* The mark that begins right after `position`, or SD_CRANK_MARKS_MAX: which byte of mark_at is position + 1, all four compared at
 * once. The lowest byte that differs from it in nothing is the one at which subtracting 1 first borrows. */
static inline uint32_t sd_wheel_mark_after(const sd_crank_t *self, uint32_t position) {
    const uint32_t off = self->mark_at ^ ((position + 1u) * 0x01010101u), hit = (off - 0x01010101u) & ~off & 0x80808080u;
    return (hit == 0u) ? SD_CRANK_MARKS_MAX : (uint32_t)__builtin_ctz(hit) >> 3;
}
uint32_t sd_wheel_first_after(const sd_crank_t *self, uint32_t mark);
uint32_t sd_wheel_step(const sd_crank_t *self, uint32_t position, int32_t teeth);
void sd_wheel_reset_widths(sd_crank_t *self);
void sd_wheel_set_width(sd_crank_t *self, uint32_t mark, int32_t spacings);
void sd_wheel_learn(sd_crank_t *self, uint32_t mark, int32_t late);
void sd_wheel_measure(sd_crank_t *self, uint32_t mark, uint32_t slot, bool quiet);

/* Pairs of marks with one tooth between them: whether there are any, and whether one follows `mark`. */
static inline bool sd_wheel_has_pairs(const sd_crank_t *self) { return self->search_marks > 15u; }
static inline bool sd_wheel_pair_follows(const sd_crank_t *self, uint32_t mark) { return ((self->search_marks >> (4u + mark)) & 1u) != 0u; }
/* Teeth from `mark` to the next, of a pair to the first. */
static inline uint32_t sd_wheel_teeth_after(const sd_crank_t *self, uint32_t mark) {
    return self->mark_teeth[mark] - (sd_wheel_pair_follows(self, mark) ? 1u : 0u);
}
/* Whether one tooth alone lies between `mark` and the next. */
static inline bool sd_wheel_begins_pair(const sd_crank_t *self, uint32_t mark) { return self->mark_teeth[mark] == 1u; }
static inline uint32_t sd_wheel_mark_before(const sd_crank_t *self, uint32_t mark) {
    return (mark > 0u) ? mark - 1u : self->mark_count - 1u;
}
static inline bool sd_wheel_ends_pair(const sd_crank_t *self, uint32_t mark) {
    return sd_wheel_begins_pair(self, sd_wheel_mark_before(self, mark));
}

/* ---- sd_crank_mark.c: whether the mark is where it should be ---- */

void sd_mark_passed(sd_crank_t *self, uint32_t tick, const sd_crank_way_t *way, int32_t to_mark, uint32_t mark, bool clean);
void sd_mark_vote(sd_crank_t *self);

/* ---- sd_crank_search.c: which gap is the mark ---- */

void sd_search_begin(sd_crank_t *self);
/* Takes the newest interval, `period` ticks. Returns true, and fills the tooth, when it gave sync. */
bool sd_search_edge(sd_crank_t *self, uint32_t tick, uint32_t period, sd_tooth_t *tooth);

/* ---- sd_crank_track.c: which tooth an edge is ---- */

void sd_track_begin(sd_crank_t *self, uint32_t tick, uint32_t position);
/* Returns false when the angle is lost. */
bool sd_track_edge(sd_crank_t *self, uint32_t tick, uint32_t raw_period, sd_tooth_t *tooth);

#ifdef __cplusplus
}
#endif

#endif
