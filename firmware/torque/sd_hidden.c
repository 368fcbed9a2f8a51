/* SPDX-License-Identifier: MIT */
#include "sd_hidden.h"

#define K_SD         20.0f /* N m/mg: torque of a mg of fuel, in all firings */
#define K_APART      0.25f /* of it: by which firings are apart */
#define O_SD         15.0f /* N m/bar: motored torque that the calibration has wrong, in all firings */
#define O_APART      0.1f  /* of it: by which firings are apart */
#define ELSEWHERE    0.1f  /* change of speed and fuel together, relative, from which e is another one */
#define FAR          0.3f  /* the change over which it forgets half of itself */

enum { K = SD_HIDDEN_FUEL, O = SD_HIDDEN_CHARGE, E = SD_HIDDEN_MEAN, P = SD_HIDDEN_PATTERN, N = SD_HIDDEN_STATES };

static uint32_t at(uint32_t i, uint32_t j) { return (i >= j) ? i * (i + 1u) / 2u + j : j * (j + 1u) / 2u + i; }

static float square(float x) { return x * x; }

static float change(float from, float to) { return __builtin_fabsf(to - from) / ((from > 1e-3f) ? from : 1e-3f); }

static void take_point(sd_hidden_t *self, const sd_hidden_reading_t *reading) {
    self->speed_radps = reading->speed_radps;
    self->fuel_mg = reading->fuel_mg;
}

static void begin(sd_hidden_t *self, const sd_hidden_reading_t *reading, float size, float doubt, bool common, float prior_rad) {
    for (uint32_t i = 0; i < N; ++i) { self->x[i] = 0.0f; }
    for (uint32_t i = 0; i < N * (N + 1u) / 2u; ++i) { self->c[i] = 0.0f; }
    self->c[at(K, K)] = square(size * K_SD * (common ? 1.0f : K_APART));
    self->c[at(O, O)] = square(size * O_SD * (common ? 1.0f : O_APART));
    self->c[at(E, E)] = square(size * doubt);
    self->c[at(P, P)] = square(prior_rad);
    take_point(self, reading);
}

/* At another operating point e is another one. */
static void move(sd_hidden_t *self, const sd_hidden_reading_t *reading, float size, float doubt) {
    const float off = change(self->speed_radps, reading->speed_radps) + change(self->fuel_mg, reading->fuel_mg);
    if (off < ELSEWHERE) { return; }
    const float keeps = 1.0f / (1.0f + off / FAR);
    self->x[E] *= keeps;
    for (uint32_t i = 0; i < N; ++i) { self->c[at(E, i)] *= (i == (uint32_t)E) ? keeps * keeps : keeps; }
    self->c[at(E, E)] += (1.0f - keeps * keeps) * square(size * doubt);
    take_point(self, reading);
}

void sd_hidden_step(sd_hidden_t *self, const sd_hidden_reading_t *reading, float size, float doubt, bool common,
                    float prior_rad) {
    if (!(self->c[at(P, P)] > 0.0f)) { begin(self, reading, size, doubt, common, prior_rad); }
    move(self, reading, size, doubt);
    const float h[N] = { reading->fuel_mg, reading->charge_bar, reading->mean_nm, reading->scale_nm };
    float gain[N], off = reading->z_nm, variance = reading->variance;
    for (uint32_t i = 0; i < N; ++i) {
        gain[i] = 0.0f;
        for (uint32_t j = 0; j < N; ++j) { gain[i] += self->c[at(i, j)] * h[j]; }
        off -= self->x[i] * h[i];
        variance += gain[i] * h[i];
    }
    for (uint32_t i = 0; i < N; ++i) {
        self->x[i] += gain[i] * (off / variance);
        for (uint32_t j = 0; j <= i; ++j) { self->c[at(i, j)] -= gain[i] * gain[j] / variance; }
    }
    /* Rounding must not make of little uncertainty less than none. */
    for (uint32_t i = 0; i < N; ++i) { self->c[at(i, i)] = (self->c[at(i, i)] > 1e-14f) ? self->c[at(i, i)] : 1e-14f; }
}

float sd_hidden_variance(const sd_hidden_t *self, float prior_rad) {
    return (self->c[at(P, P)] > 0.0f) ? self->c[at(P, P)] : square(prior_rad);
}

bool sd_hidden_ok(const sd_hidden_t *self) {
    bool ok = true;
    for (uint32_t i = 0; i < N; ++i) { ok = ok && (self->c[at(i, i)] >= 0.0f); }
    return ok;
}
