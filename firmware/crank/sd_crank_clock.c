/* SPDX-License-Identifier: MIT */
#include "sd_crank_parts.h"

enum { TREND_LASTS = 3 * ONE }; /* speed ripple turns round within a few teeth */

/* A share of an error, in parts of 4096: whole times the error and, so that one multiplication does, the rest Q32. */
typedef struct sd_share { int32_t whole, rest; } sd_share_t;
#define SHARE(parts) { ((parts) + 2048) / 4096, (int32_t)(((parts) - 4096 * (((parts) + 2048) / 4096)) * (1 << 20)) }

/* Steady gains of a fading-memory fit. What an edge weighs shrinks by 0.2, 0.5 and 0.85 a tooth. The fits are
 * quadratic; that of the memory, which knows the bends, is straight. */
typedef struct sd_gains { sd_share_t time, period, change; } sd_gains_t;
static const sd_gains_t QUICK_GAINS = { SHARE(4063), SHARE(4719), SHARE(2096) };
static const sd_gains_t MEMORY_GAINS = { SHARE(3072), SHARE(1024), SHARE(0) };
static const sd_gains_t CALM_GAINS = { SHARE(1581), SHARE(256), SHARE(14) };

/* ---- forecasts ------------------------------------------------------------------------------------------------- */

static sd_forecast_t recall(const sd_crank_clocks_t *clocks, const sd_crank_way_t *way) {
    const int32_t time = (int32_t)sd_by_ratio(way->recalled, clocks->ratio);
    int32_t step = time;
    if (way->spacings != ONE) {
        step = (int32_t)sd_by_ratio(way->recalled_last, clocks->ratio);
        if (way->last > ONE) { step = (int32_t)(((uint32_t)step / ((uint32_t)way->last >> 4)) << 8); }
    }
    return (sd_forecast_t){ time, clamp_in(step, PERIOD_MIN, PERIOD_MAX) };
}

sd_forecast_t sd_clock_forecast(const sd_crank_clocks_t *clocks, uint32_t kind, const sd_crank_way_t *way) {
    if (kind == MEMORY) { return recall(clocks, way); }
    const sd_crank_clock_t *clock = &clocks->clock[kind];
    const int32_t next = clock->period + clock->change;
    if (way->spacings == ONE) { return (sd_forecast_t){ next, next }; }
    /* u (u + 1) / 2 while a trend can be trusted, then straight on. */
    const int32_t bent = (way->spacings > TREND_LASTS) ? TREND_LASTS : way->spacings;
    const int32_t bend = ((bent * (bent + ONE)) >> 13) + scale12(way->spacings - bent, bent);
    const int64_t time = ((int64_t)clock->period * way->spacings + (int64_t)clock->change * bend) >> 12;
    return (sd_forecast_t){ clamp32(time, 1, TIME_MAX), clock->period + scale12(clock->change, bent) };
}

/* A quicker clock must beat a calmer one clearly: under jitter it does so by chance, and then follows the noise. The
 * memory must be beaten by more than a hair, because it alone knows what lies behind a missing tooth. */
uint32_t sd_clock_best(const sd_crank_clocks_t *clocks, uint32_t except) {
    const int32_t quick = 4 * clocks->clock[QUICK].error, memory = 4 * clocks->clock[MEMORY].error;
    const int32_t calm = 3 * clocks->clock[CALM].error - ONE / 100;
    if ((except != MEMORY) && (memory < calm)) {
        return (quick < 3 * clocks->clock[MEMORY].error - ONE / 100) ? QUICK : MEMORY;
    }
    return (quick < calm) ? QUICK : CALM;
}

/* ---- after an edge --------------------------------------------------------------------------------------------- */

/* An edge that surprises the clock may be no tooth at all, so it moves the clock only as far as the clock's own
 * record of errors makes likely; the record grows with every surprise, so real changes get through in a few teeth. */
typedef struct sd_surprise {
    int32_t late, late_q12; /* as far as it is believed, 1/64 tick and spacings */
    int32_t error;          /* all of it, Q12 */
} sd_surprise_t;

SD_INLINE sd_surprise_t surprise(int32_t late, int32_t likely, const sd_inverse_t *inverse) {
    const int32_t off = sd_in_spacings(inverse, late);
    sd_surprise_t s = { late, off, abs32(off) };
    if (s.error > likely) {
        s.late_q12 = (off < 0) ? -likely : likely;
        s.late = scale12(inverse->period, s.late_q12);
    }
    return s;
}

SD_INLINE int32_t likely_error(int32_t mean) { return 4 * mean + ONE / 20; }

/* Errors grow with the way coasted. */
static int32_t likely_far(int32_t mean, int32_t spacings) { return (likely_error(mean) * (spacings >> 6)) >> 6; }

SD_INLINE int32_t error_after(int32_t mean, int32_t error) {
    const int32_t next = (15 * mean + error) >> 4; /* never below 0 */
    return (next < ONE / 2) ? next : ONE / 2;
}

SD_INLINE int32_t part_of(int32_t late, sd_share_t share) {
    return plus32(late * share.whole, (int32_t)(((int64_t)late * share.rest) >> 32));
}
/* Where the share is small, rounding down would tell. */
SD_INLINE int32_t small_part_of(int32_t late, sd_share_t share) {
    return plus32(late * share.whole, (int32_t)(((int64_t)late * share.rest + 0x80000000LL) >> 32));
}

/* late_each and bend: how late for each spacing, and how late for each spacing and spacing. */
SD_INLINE void fit(sd_crank_clock_t *clock, const sd_crank_clock_t *before, const sd_gains_t *gain, sd_forecast_t ahead, sd_surprise_t s,
                   int32_t late_each, int32_t bend) {
    const int32_t period = clamp_in(plus32(ahead.period, part_of(late_each, gain->period)), PERIOD_MIN, PERIOD_MAX);
    const int32_t most = period >> 3;
    clock->time = before->time + (uint32_t)ahead.time + (uint32_t)part_of(s.late, gain->time);
    clock->period = period;
    clock->change = clamp_in(plus32(before->change, small_part_of(bend, gain->change)), -most, most);
    clock->error = error_after(before->error, s.error);
}

/* One clock over one spacing, which needs no division. Returns its error. */
SD_INLINE int32_t move_one(sd_crank_clock_t *clock, const sd_crank_clock_t *before, const sd_gains_t *gain, uint32_t tick,
                           const sd_inverse_t *inverse) {
    const int32_t next = before->period + before->change;
    const sd_surprise_t s = surprise(sd_clock_late(before, tick, next), likely_error(before->error), inverse);
    fit(clock, before, gain, (sd_forecast_t){ next, next }, s, s.late, s.late);
    return s.error;
}

/* And over any way; each: 1 / spacings, Q12. */
static int32_t move_one_far(sd_crank_clocks_t *to, const sd_crank_clocks_t *from, uint32_t kind, uint32_t tick, int32_t spacings,
                            int32_t each, const sd_inverse_t *inverse) {
    const sd_crank_clock_t *before = &from->clock[kind];
    const sd_crank_way_t way = { .spacings = spacings };
    const sd_forecast_t ahead = sd_clock_forecast(from, kind, &way);
    const sd_surprise_t s = surprise(sd_clock_late(before, tick, ahead.time), likely_far(before->error, spacings), inverse);
    const int32_t late_each = scale12(s.late, each);
    fit(&to->clock[kind], before, (kind == CALM) ? &CALM_GAINS : &QUICK_GAINS, ahead, s, late_each, scale12(late_each, each));
    return s.error;
}

/* The memory after an edge that was `s` later than it foretold. What it holds of the tooth takes a quarter of the news
 * each revolution: jitter averages out, a change of speed gets in. What surprises the memory more than the quick clock is
 * no fault: a cylinder fires, and the memory is history. */
SD_INLINE void fit_memory(sd_crank_t *self, sd_forecast_t ahead, sd_surprise_t s, int32_t each, int32_t quick_error, bool clean) {
    const sd_crank_clocks_t *from = &self->clocks[self->now ^ 1u];
    sd_crank_clocks_t *to = &self->clocks[self->now];
    const sd_crank_clock_t *before = &from->clock[MEMORY];
    sd_crank_clock_t *clock = &to->clock[MEMORY];
    const int32_t late_each = (each != ONE) ? scale12(s.late, each) : s.late;
    const int32_t more = part_of(late_each, MEMORY_GAINS.period);
    const int32_t grown = ahead.period - before->period;
    int32_t error = error_after(before->error, s.error);
    const int32_t off = (each != ONE) ? scale12(s.late_q12, each) : s.late_q12;
    to->ratio = (uint32_t)clamp_in((int32_t)from->ratio + (int32_t)(((int64_t)from->ratio * off) >> 14), RATIO_MIN, RATIO_MAX);
    clock->time = before->time + (uint32_t)ahead.time + (uint32_t)part_of(s.late, MEMORY_GAINS.time);
    clock->period = clamp_in(plus32(ahead.period, more), PERIOD_MIN, PERIOD_MAX);
    clock->change = (each != ONE) ? scale12(grown, each) : grown;
    if (clean) {
        uint32_t *known = &self->memory[self->slot];
        *known += (uint32_t)(minus32(plus32(ahead.time, s.late), (int32_t)*known) >> 2);
        const bool quick_was_right = to->clock[QUICK].error < error + ONE / 20;
        if (quick_was_right && (s.error > quick_error + ONE / 20)) { error = clamp_in(error + ((s.error - error) >> 1), 0, ONE / 2); }
    }
    clock->error = error;
}

static void move_memory_far(sd_crank_t *self, uint32_t tick, int32_t each, int32_t quick_error, bool clean, const sd_inverse_t *inverse) {
    const sd_crank_clocks_t *from = &self->clocks[self->now ^ 1u];
    const sd_crank_clock_t *before = &from->clock[MEMORY];
    const sd_forecast_t ahead = recall(from, &self->placed_way);
    const int32_t likely = likely_far(before->error, self->placed_way.spacings);
    const sd_surprise_t s = surprise(sd_clock_late(before, tick, ahead.time), likely, inverse);
    fit_memory(self, ahead, s, each, quick_error, clean);
}

/* The way that lies behind us was one spacing, `inverse` of the period there: every clock takes the edge. */
void sd_clocks_move(sd_crank_t *self, uint32_t tick, bool clean, const sd_inverse_t *inverse) {
    const sd_crank_clocks_t *from = &self->clocks[self->now ^ 1u];
    sd_crank_clocks_t *to = &self->clocks[self->now];
    move_one(&to->clock[CALM], &from->clock[CALM], &CALM_GAINS, tick, inverse);
    const int32_t quick_error = move_one(&to->clock[QUICK], &from->clock[QUICK], &QUICK_GAINS, tick, inverse);
    self->last_tick = tick;
    if (self->unlearned > 0u) {
        to->leader = sd_clock_best(to, MEMORY);
        return;
    }
    const sd_crank_clock_t *before = &from->clock[MEMORY];
    const int32_t next = (int32_t)sd_by_ratio(self->placed_way.recalled, from->ratio);
    const sd_surprise_t s = surprise(sd_clock_late(before, tick, next), likely_error(before->error), inverse);
    fit_memory(self, (sd_forecast_t){ next, next }, s, ONE, quick_error, clean);
    to->leader = sd_clock_best(to, SD_CRANK_CLOCKS);
}

/* The same over a longer way. What a mark's width is blamed for moves only the calm clock's idea of the way, not of the
 * time: the quick one is there for ripple, and needs the news that a mark's long period brings. */
void sd_clocks_move_far(sd_crank_t *self, uint32_t tick, bool clean, const sd_inverse_t *inverse) {
    const sd_crank_clocks_t *from = &self->clocks[self->now ^ 1u];
    sd_crank_clocks_t *to = &self->clocks[self->now];
    const int32_t spacings = self->placed_way.spacings;
    const int32_t each = (ONE * ONE) / spacings;
    move_one_far(to, from, CALM, tick, spacings + self->placed_excused, each, inverse);
    const int32_t quick_error = move_one_far(to, from, QUICK, tick, spacings, each, inverse);
    self->last_tick = tick;
    if (self->unlearned == 0u) { move_memory_far(self, tick, each, quick_error, clean, inverse); }
    to->leader = sd_clock_best(to, (self->unlearned > 0u) ? MEMORY : SD_CRANK_CLOCKS);
}
