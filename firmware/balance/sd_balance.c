/* SPDX-License-Identifier: MIT */
#include "sd_balance.h"

#include <string.h>

#define SMOOTH 0.25f /* a cycle */

enum { WATCH_AFTER = 8 }; /* cycles of learning until the smoothed rms means something */
#define PATIENCE 3.0f     /* over the gain: in that many cycles a right loop has worn a step down */

static bool above_to(float x, float above, float to) { return (x > above) && (x <= to); }

static bool config_ok(const sd_balance_config_t *c) {
    return (c->cylinders >= 2u) && (c->cylinders <= SD_BALANCE_CYLINDERS_MAX) && above_to(c->gain, 0.0f, 1.0f) &&
           above_to(c->rate, 0.0f, 1.0f) && above_to(c->limit, 0.0f, 0.5f) && above_to(c->sd_max, 0.0f, 1.0f);
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
    self->mean_square = self->noise = 0.0f;
    self->least = 1e9f;
    self->learned = 0;
    self->hold = self->grown = 0;
    self->diverged = self->at_limit = 0;
}

static float clamp(float x, float limit) { return (x > limit) ? limit : (x < -limit) ? -limit : x; }

sd_result_t sd_balance_configure(sd_balance_t *self, const sd_balance_config_t *c) {
    if (!config_ok(c) || (c->cylinders != self->config.cylinders)) { return SD_ERR_CONFIG; }
    self->config = *c;
    for (uint32_t i = 0; i < c->cylinders; ++i) { self->trim[i] = clamp(self->trim[i], c->limit); }
    return SD_OK;
}

/* Finite, plausible, and trusted enough. */
static bool usable(const sd_balance_t *self, const float *deviation, const float *sd) {
    bool ok = true;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        ok = ok && (deviation[i] > -2.0f) && (deviation[i] < 2.0f) && (sd[i] >= 0.0f) && (sd[i] <= self->config.sd_max);
    }
    return ok;
}

static void learn(sd_balance_t *self, const float *deviation) {
    const uint32_t n = self->config.cylinders;
    float mean = 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        self->trim[i] -= clamp(self->config.gain * deviation[i], self->config.rate);
        mean += self->trim[i] / (float)n;
    }
    self->at_limit = 0;
    for (uint32_t i = 0; i < n; ++i) {
        const float wanted = self->trim[i] - mean;
        self->trim[i] = clamp(wanted, self->config.limit);
        if (self->trim[i] != wanted) { self->at_limit = 1; }
    }
}

/* Squares throughout: twice the least rms is four times the least square. */
static void watch(sd_balance_t *self, const float *deviation, const float *sd) {
    float square = 0.0f, noise = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        square += deviation[i] * deviation[i] / (float)self->config.cylinders;
        noise += sd[i] * sd[i] / (float)self->config.cylinders;
    }
    const float part = (self->learned < 3u) ? 1.0f / (float)(self->learned + 1u) : SMOOTH;
    self->mean_square += part * (square - self->mean_square);
    self->noise += part * (noise - self->noise);
    if (self->learned < UINT32_MAX) { self->learned++; }
    if (self->learned < WATCH_AFTER) { return; }
    if (self->mean_square < self->least) { self->least = self->mean_square; }
    const bool grown = self->mean_square > 4.0f * self->least + 4.0f * self->noise;
    self->grown = grown ? (uint16_t)(self->grown + 1u) : 0u;
    if ((float)self->grown * self->config.gain > PATIENCE) {
        memset(self->trim, 0, sizeof self->trim);
        self->diverged = 1;
    }
}

void sd_balance_step(sd_balance_t *self, const float *deviation, const float *sd, uint8_t health, uint8_t transient) {
    if (self->diverged != 0u) { return; }
    if ((health != SD_VALID) || (transient != 0u) || !usable(self, deviation, sd)) {
        self->hold = self->config.hold_cycles;
        if (self->hold == 0u) { self->hold = 1; }
        return;
    }
    if (self->hold > 0u) { self->hold--; return; }
    watch(self, deviation, sd);
    if (self->diverged == 0u) { learn(self, deviation); }
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
