/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "sd_crank_parts.h"

enum {
    TREND_LASTS     = 3 * ONE,          /* speed ripple turns round within a few teeth */
};

/* Steady gains of a fading-memory fit (Q12): share of an error given to time, period, change. What an edge weighs
 * shrinks by 0.2, 0.5, 0.5 and 0.85 a tooth. The fits are quadratic; that of the memory, which knows the bends, is
 * straight. */
typedef struct sd_gains { int32_t time, period, change; } sd_gains_t;
static const sd_gains_t GAINS[SD_CRANK_CLOCKS] = {
    { 4063, 4719, 2097 }, { 3584, 2304, 512 }, { 3072, 1024, 0 }, { 1581, 256, 14 }
};

int64_t sd_clock_since(const sd_crank_clock_t *c, uint32_t tick) {
    return ((int64_t)(int32_t)(tick - c->tick) * 64) - c->frac;
}

sd_forecast_t sd_clock_forecast(const sd_crank_clock_t *c, uint32_t kind, const sd_crank_way_t *way) {
    int64_t time, period;
    if (kind == MEMORY) {
        time = ((int64_t)c->period * way->recalled) / way->period_from;
        period = ((int64_t)c->period * way->period_to) / way->period_from;
    } else {
        /* u (u + 1) / 2 while a trend can be trusted, then straight on. */
        const int64_t bent = (way->spacings > TREND_LASTS) ? TREND_LASTS : way->spacings;
        const int64_t bend = ((bent * (bent + ONE)) >> 13) + (((way->spacings - bent) * bent) >> 12);
        time = (((int64_t)c->period * way->spacings) >> 12) + (((int64_t)c->change * bend) >> 12);
        period = c->period + (((int64_t)c->change * bent) >> 12);
    }
    return (sd_forecast_t){ time, clamp32(period, c->period / 4, 4 * (c->period / 2)) };
}

/* How late `elapsed` is against a forecast, Q12 spacings. */
int32_t sd_clock_lateness(const sd_forecast_t *ahead, int64_t elapsed) {
    return clamp32(((elapsed - ahead->time) * ONE) / ahead->period, -16 * ONE, 16 * ONE);
}

/* A quicker clock must beat a calmer one clearly: under jitter it does so by chance, and then follows the noise. The
 * memory must be beaten by more than a hair, because it alone knows what lies behind a missing tooth. */
uint8_t sd_clock_best(const sd_crank_t *self, uint32_t except) {
    uint32_t best = CALM;
    for (uint32_t i = CALM; i-- > 0u;) {
        if ((i != except) && (4 * self->clock[i].error + ONE / 100 < 3 * self->clock[best].error)) { best = i; }
    }
    return (uint8_t)best;
}

void sd_clock_start(sd_crank_clock_t *c, uint32_t tick, uint32_t period_ticks) {
    *c = (sd_crank_clock_t){ .tick = tick, .period = (int32_t)(period_ticks << 6), .error = ONE / 16 };
}

/* An edge that surprises the clock may be no tooth at all, so it moves the clock only as far as the clock's own
 * record of errors makes likely; the record grows with every surprise, so real changes get through in a few teeth. */
int32_t sd_clock_place(sd_crank_clock_t *c, uint32_t kind, uint32_t tick, const sd_crank_way_t *way) {
    const sd_gains_t *gain = &GAINS[kind];
    const sd_forecast_t ahead = sd_clock_forecast(c, kind, way);
    const int64_t elapsed = sd_clock_since(c, tick);
    const int32_t error = abs32(sd_clock_lateness(&ahead, elapsed));
    const int32_t likely = ((4 * c->error + ONE / 20) * (way->spacings >> 6)) >> 6; /* errors grow with the way coasted */
    int64_t late = elapsed - ahead.time;
    if (error > likely) { late = (late * likely) / error; }
    const int64_t fitted = ahead.time + ((late * gain->time + ONE / 2) >> 12) + c->frac;
    const int64_t late_each = (late * ONE) / way->spacings;
    const int32_t period = ahead.period + (int32_t)((late_each * gain->period + ONE / 2) >> 12);
    const int64_t change = (kind == MEMORY) ? (((int64_t)ahead.period - c->period) * ONE) / way->spacings
                                            : c->change + (((late_each * ONE) / way->spacings * gain->change + ONE / 2) >> 12);
    c->tick += (uint32_t)(fitted >> 6);
    c->frac = (int32_t)(fitted & 63);
    c->period = clamp32(period, 64, STALL_TICKS_MAX << 6);
    c->change = clamp32(change, -c->period / 8, c->period / 8);
    c->error = clamp32(c->error + (error - c->error) / 16, 0, ONE / 2);
    return error;
}

/* The angle moved, so what is remembered belongs to other teeth. */
void sd_memory_forget(sd_crank_t *self) { memset(self->memory, 0, sizeof self->memory); }
