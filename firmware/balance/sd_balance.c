/* SPDX-License-Identifier: MIT */
#include "sd_balance.h"

#include <string.h>

#include "sd_math.h"

#define SMOOTH     0.25f /* a cycle */
#define GAIN_LEAST 0.5f  /* of the gain, where noise explains all that deviates */

enum { SMOOTH_FROM = 3 }; /* cycles; before, the mean of all so far */
enum { IDLE = 0, WATCH, LEARN }; /* what is next */

static bool config_ok(const sd_balance_config_t *c) {
    return (c->cylinders >= 2u) && (c->cylinders <= SD_BALANCE_CYLINDERS_MAX) && sd_above_to(c->gain, 0.0f, 1.0f) &&
           sd_within(c->proportional, 0.0f, 1.0f) &&
           sd_above_to(c->rate, 0.0f, 1.0f) && sd_above_to(c->limit, 0.0f, 0.5f) && sd_above_to(c->sd_max, 0.0f, 1.0f);
}

sd_result_t sd_balance_init(sd_balance_t *self, const sd_balance_config_t *c) {
    if (!config_ok(c)) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->config = *c;
    sd_balance_restart(self);
    return SD_OK;
}

void sd_balance_restart(sd_balance_t *self) {
    memset(self->trim, 0, sizeof self->trim);
    sd_watch_init(&self->watch, self->config.cylinders);
    self->mean_square = self->noise = 0.0f;
    self->learned = 0;
    self->hold = 0;
    self->diverged = self->at_limit = self->has_last = 0;
    self->at_work = IDLE;
}

void sd_balance_resume(sd_balance_t *self) {
    sd_watch_init(&self->watch, self->config.cylinders);
    self->diverged = self->has_last = 0;
    self->at_work = IDLE;
    self->hold = self->config.hold_cycles;
}

/* To what is as far on either side. */
static float limited(float x, float limit) { return sd_clamp(x, -limit, limit); }

sd_result_t sd_balance_configure(sd_balance_t *self, const sd_balance_config_t *c) {
    if (!config_ok(c) || (c->cylinders != self->config.cylinders)) { return SD_ERR_CONFIG; }
    self->config = *c;
    for (uint32_t i = 0; i < c->cylinders; ++i) { self->trim[i] = limited(self->trim[i], c->limit); }
    return SD_OK;
}

/* Finite, plausible, and trusted enough. */
static bool usable(const sd_balance_t *self, const sd_balance_input_t *in) {
    bool ok = (in->health == SD_VALID) && sd_above_to(in->follow, 0.0f, 1.0f);
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        ok = ok && (in->deviation[i] > -2.0f) && (in->deviation[i] < 2.0f) && (in->sd[i] >= 0.0f) && (in->sd[i] <= self->config.sd_max);
    }
    return ok;
}

/* Mean squares of what deviates and of what noise would. Returns the latter of this cycle. */
static float take_squares(sd_balance_t *self, const sd_balance_input_t *in) {
    float square = 0.0f, noise = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        square += in->deviation[i] * in->deviation[i] / (float)self->config.cylinders;
        noise += in->sd[i] * in->sd[i] / (float)self->config.cylinders;
    }
    const float part = (self->learned < SMOOTH_FROM) ? 1.0f / (float)(self->learned + 1u) : SMOOTH;
    self->mean_square += part * (square - self->mean_square);
    self->noise += part * (noise - self->noise);
    if (self->learned < UINT32_MAX) { self->learned++; }
    return noise;
}

static void learn(sd_balance_t *self) {
    const uint32_t n = self->config.cylinders;
    const float real = (self->mean_square > self->noise) ? 1.0f - self->noise / self->mean_square : 0.0f;
    const float gain = self->config.gain * (GAIN_LEAST + (1.0f - GAIN_LEAST) * real);
    const float proportional = (self->has_last != 0u) ? self->config.proportional : 0.0f; /* across a hold no change is known */
    float mean = 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        const float change = proportional * (self->deviation[i] - self->last[i]);
        self->trim[i] -= limited(gain * self->deviation[i] + change, self->config.rate);
        self->last[i] = self->deviation[i];
        mean += self->trim[i] / (float)n;
    }
    self->has_last = 1;
    self->at_limit = 0;
    for (uint32_t i = 0; i < n; ++i) {
        const float wanted = self->trim[i] - mean;
        self->trim[i] = limited(wanted, self->config.limit);
        if (self->trim[i] != wanted) { self->at_limit = 1; }
    }
}

static void retreat(sd_balance_t *self) {
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { self->trim[i] -= limited(self->trim[i], self->config.rate); }
    self->at_limit = 0;
}

void sd_balance_begin(sd_balance_t *self, const sd_balance_input_t *in) {
    self->at_work = IDLE;
    if (self->diverged != 0u) {
        retreat(self);
        return;
    }
    if ((in->transient != 0u) || !usable(self, in)) {
        self->hold = (self->config.hold_cycles > 0u) ? self->config.hold_cycles : 1u;
        self->has_last = 0;
        sd_watch_resume(&self->watch);
        return;
    }
    if (self->hold > 0u) { self->hold--; return; }
    memcpy(self->deviation, in->deviation, self->config.cylinders * sizeof(float));
    const float variance = take_squares(self, in);
    sd_watch_begin(&self->watch, in->deviation, self->trim, in->told != 0u, variance, in->follow);
    self->at_work = WATCH;
}

bool sd_balance_work(sd_balance_t *self) {
    if (self->at_work == (uint8_t)WATCH) {
        if (sd_watch_work(&self->watch)) { return true; }
        self->diverged = sd_watch_wrong(&self->watch) ? 1u : 0u;
        self->at_work = (self->diverged == 0u) ? LEARN : IDLE;
    } else {
        if (self->at_work == (uint8_t)LEARN) { learn(self); }
        self->at_work = IDLE;
    }
    return self->at_work != (uint8_t)IDLE;
}

sd_status_t sd_balance_status(const sd_balance_t *self) {
    sd_status_t status = { .health = SD_VALID };
    if (self->diverged != 0u) {
        status.health = SD_INVALID;
        status.why = SD_WHY_FAULT;
    } else if ((self->hold > 0u) || (self->at_limit != 0u)) {
        status.health = SD_DEGRADED;
        status.why = (self->hold > 0u) ? SD_WHY_CONVERGING : SD_WHY_REJECTED;
    }
    return status;
}
