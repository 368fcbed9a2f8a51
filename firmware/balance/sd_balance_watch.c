/* SPDX-License-Identifier: MIT */
#include "sd_balance_watch.h"

#include <string.h>

#define USUAL          (1.0f / 12.0f) /* a cycle, of an estimate that takes up PROMPT in one; slower for slower ones */
#define PROMPT         0.3f
#define VARIANCE_LEAST 3e-4f          /* (1.7 %)^2: what a right model may be off by */

typedef struct { float re, im; } complex_t;

static complex_t times(complex_t a, complex_t b) {
    return (complex_t){ a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re };
}

void sd_watch_init(sd_watch_t *self, uint8_t cylinders) {
    /* exp(j 120 deg/n), n = 2 to 8 */
    static const complex_t unit[] = { { 0.5f, 0.8660254f }, { 0.7660444f, 0.6427876f }, { 0.8660254f, 0.5f },
                                      { 0.9135455f, 0.4067366f }, { 0.9396926f, 0.3420201f }, { 0.9555728f, 0.2947552f },
                                      { 0.9659258f, 0.2588190f } };
    memset(self, 0, sizeof *self);
    self->cylinders = cylinders;
    complex_t power = { 1.0f, 0.0f };
    for (uint32_t k = 0; k < 3u * cylinders; ++k) {
        self->turn[k][0] = power.re;
        self->turn[k][1] = power.im;
        power = times(power, unit[cylinders - 2u]);
    }
}

void sd_watch_resume(sd_watch_t *self) { self->begun = self->order = 0; }

static complex_t turn_of(const sd_watch_t *self, uint32_t k) {
    const float *t = self->turn[k % (3u * self->cylinders)];
    return (complex_t){ t[0], t[1] };
}

/* Pattern of order m in what differs from the usual; all orders, both signs, hold the sum of squares n times. */
static complex_t pattern(const sd_watch_t *self, const float *x, const float *usual, uint32_t order) {
    complex_t sum = { 0.0f, 0.0f };
    for (uint32_t i = 0; i < self->cylinders; ++i) {
        const complex_t turn = turn_of(self, 3u * order * i);
        sum.re += turn.re * (x[i] - usual[i]);
        sum.im -= turn.im * (x[i] - usual[i]);
    }
    return sum;
}

/* |injector - (turn - 1) shown|^2 */
static float misfit(complex_t injector, complex_t shown, complex_t turn) {
    turn.re -= 1.0f;
    const complex_t expected = times(turn, shown);
    const float re = injector.re - expected.re, im = injector.im - expected.im;
    return re * re + im * im;
}

/* What one order says of this cycle, both signs. */
static void weigh(sd_watch_t *self, uint32_t m) {
    const complex_t seen = pattern(self, self->last_injector, self->usual_injector, m),
        shown = pattern(self, self->shown, self->usual_shown, m);
    complex_t right = turn_of(self, m), wrong = turn_of(self, 2u * m);
    const bool alternating = 2u * m == self->cylinders; /* has no phase: only what is in line with it comes back */
    if (alternating) { right.im = wrong.im = 0.0f; }
    for (uint32_t sign = 0; sign < 2u; ++sign) {
        self->gain[sign] += (alternating ? 1.0f : 2.0f) * (misfit(seen, shown, right) - misfit(seen, shown, wrong));
        right.im = -right.im;
        wrong.im = -wrong.im;
    }
}

/* More than trims can do in a cycle, turned however they may be: the injector did it. */
static bool jumped(const sd_watch_t *self, const float *injector, float shown_move, float variance) {
    const float most = 4.0f * shown_move * shown_move + 16.0f * variance;
    for (uint32_t i = 0; i < self->cylinders; ++i) {
        const float move = injector[i] - self->last_injector[i];
        if (move * move > most) { return true; }
    }
    return false;
}

void sd_watch_begin(sd_watch_t *self, const float *deviation, const float *trim, bool told, float variance, float follow) {
    float injector[SD_BALANCE_CYLINDERS_MAX] = { 0.0f }, shown_move = 0.0f;
    const float spread = (variance > VARIANCE_LEAST) ? variance : VARIANCE_LEAST;
    for (uint32_t i = 0; i < self->cylinders; ++i) {
        if (self->begun == 0u) { self->shown[i] = trim[i]; }
        const float move = follow * (trim[i] - self->shown[i]);
        self->shown[i] += move;
        if (move * move > shown_move * shown_move) { shown_move = move; }
        injector[i] = deviation[i] - (told ? trim[i] : self->shown[i]);
    }
    if ((self->begun == 0u) || jumped(self, injector, shown_move, spread)) {
        memcpy(self->usual_injector, injector, sizeof injector);
        memcpy(self->usual_shown, self->shown, sizeof self->shown);
    }
    memcpy(self->last_injector, injector, sizeof injector);
    self->begun = 1;
    /* Errors of an estimate hang together over 1/follow cycles: so much less does a cycle say. */
    self->scale = 0.25f * follow / (spread * (float)self->cylinders);
    self->usual = (follow < PROMPT) ? USUAL * follow / PROMPT : USUAL;
    self->gain[0] = self->gain[1] = 0.0f;
    self->order = 1;
}

/* The log likelihood ratio of the cycle, summed; and its values go into the means. */
static void finish(sd_watch_t *self) {
    for (uint32_t sign = 0; sign < 2u; ++sign) {
        self->evidence[sign] += self->scale * self->gain[sign];
        if (!(self->evidence[sign] > 0.0f)) { self->evidence[sign] = 0.0f; }
    }
    for (uint32_t i = 0; i < self->cylinders; ++i) {
        self->usual_injector[i] += self->usual * (self->last_injector[i] - self->usual_injector[i]);
        self->usual_shown[i] += self->usual * (self->shown[i] - self->usual_shown[i]);
    }
}

bool sd_watch_work(sd_watch_t *self) {
    if (self->order == 0u) { return false; }
    weigh(self, self->order);
    self->order = (2u * (self->order + 1u) <= self->cylinders) ? (uint8_t)(self->order + 1u) : 0u;
    if (self->order == 0u) { finish(self); }
    return self->order != 0u;
}

bool sd_watch_wrong(const sd_watch_t *self) {
    return (self->evidence[0] > SD_WATCH_LIMIT) || (self->evidence[1] > SD_WATCH_LIMIT);
}
