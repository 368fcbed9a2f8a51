/* SPDX-License-Identifier: MIT */
#include "sd_twist.h"

#include <string.h>

#include "sd_teeth.h"

#define STEP          2e-3f /* share by which the trial is faster */
#define PRIOR_SD      0.05f /* 10 % of stiffness */
#define MODEL_RAD     5e-5f /* rms of the differences that an error of the model makes, 0.003 deg */
#define WALK          1e-5f /* springs age, a cycle */
#define MOVE_MAX      0.01f /* in one cycle */
#define DEVIATION_MAX 0.1f
#define CURVATURE     1.0f  /* of a step, squared, that is left to learn anew */
#define KNOWN_RAD     1e-4f
#define RAD2_MAX      100.0f /* beyond it, it is no crank that turns */

static float within(float x, float limit) { return (x > limit) ? limit : (x < -limit) ? -limit : x; }

static float root(float x) { return x * sd_rsqrt_f32(x); }

float sd_twist_sd(const sd_twist_sums_t *sums) {
    const float square = sums->variance + sums->bias * sums->bias;
    return (square > 0.0f) ? root(square) : 0.0f;
}

static void tune(sd_kalman_t *filter, float ratio) {
    filter->tuning.frequency = ratio;
    filter->tuning.gain_speed = 1.0f / ratio;
    filter->tuning.compliance = 1.0f / (ratio * ratio);
}

void sd_twist_tune(const sd_twist_sums_t *sums, sd_kalman_t *filter) { tune(filter, 1.0f + sums->deviation); }

void sd_twist_begin(sd_twist_t *self, const sd_kalman_tables_t *t, const sd_kalman_t *free) {
    if (t->modes == 0u) { return; }
    const sd_kalman_t before = self->trial;
    self->trial = *free;
    memcpy(self->trial.twist_rad, before.twist_rad, sizeof before.twist_rad);
    memcpy(self->trial.swing_rad, before.swing_rad, sizeof before.swing_rad);
    tune(&self->trial, free->tuning.frequency * (1.0f + STEP));
    memset(self->sensitivity_rad, 0, sizeof self->sensitivity_rad);
}

void sd_twist_follow(sd_twist_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *predicted, float late_rad) {
    if (t->modes == 0u) { return; }
    const uint32_t k = predicted->cycle_position;
    sd_firing_t unused;
    sd_kalman_step(&self->trial, t, predicted, &unused);
    const float share = (sd_kalman_late(&self->trial, t, k) - late_rad) * (1.0f / STEP);
    self->sensitivity_rad[k % t->positions] += (k < t->positions) ? -share : share;
}

static void detrend(const sd_kalman_tables_t *t, const float *values, float *left) {
    float level, slope;
    sd_teeth_line(t, values, &level, &slope);
    for (uint32_t k = 0; k < t->positions; ++k) { left[k] = values[k] - level - slope * ((float)k - 0.5f * (float)t->positions); }
}

/* The modes would swing otherwise by now. */
static void carry_on(sd_twist_t *self, const sd_kalman_tables_t *t, float move, sd_kalman_t *free) {
    for (uint32_t m = 0; m < t->modes; ++m) {
        const float twist = (self->trial.twist_rad[m] - free->twist_rad[m]) * (move / STEP);
        const float swing = (self->trial.swing_rad[m] - free->swing_rad[m]) * (move / STEP);
        free->twist_rad[m] += twist, self->trial.twist_rad[m] += twist;
        free->swing_rad[m] += swing, self->trial.swing_rad[m] += swing;
    }
}

void sd_twist_learn(sd_twist_t *self, const sd_kalman_tables_t *t, sd_twist_sums_t *sums, float *difference_rad, sd_kalman_t *free) {
    if (t->modes == 0u) { return; }
    float d[SD_KALMAN_POSITIONS_MAX], s[SD_KALMAN_POSITIONS_MAX];
    detrend(t, difference_rad, d);
    detrend(t, self->sensitivity_rad, s);
    const float ss = sd_teeth_mean_product(t, s, s) + 1e-12f, sd = sd_teeth_mean_product(t, s, d), dd = sd_teeth_mean_product(t, d, d);
    if (!(ss < RAD2_MAX) || !(dd < RAD2_MAX)) { return; }
    const float left = dd - sd * sd / ss;
    const float jitter = ((left > 0.0f) ? left / (sd_teeth_count(t) - 3.0f) : 0.0f) / ss, bias = MODEL_RAD * root(1.0f / ss);
    /* An error of the model does not average out: where it moves the frequency further than that is known, nothing is learned. */
    const bool tells = bias < sd_twist_sd(sums);
    const float gain = tells ? sums->variance / (sums->variance + jitter + bias * bias) : 0.0f, before = sums->deviation;
    sums->deviation = within(before - within(gain * sd / ss, MOVE_MAX), DEVIATION_MAX);
    const float move = sums->deviation - before;
    sums->variance += WALK * WALK + CURVATURE * move * move - gain * sums->variance;
    sums->bias += gain * (bias - sums->bias);
    self->unknown_rad = sd_twist_sd(sums) * root(ss);
    for (uint32_t k = 0; k < t->positions; ++k) { difference_rad[k] += move * self->sensitivity_rad[k]; }
    carry_on(self, t, move, free);
    sd_twist_tune(sums, free);
}

bool sd_twist_known(const sd_twist_t *self, const sd_kalman_tables_t *t) {
    return (t->modes == 0u) || ((self->unknown_rad > 0.0f) && (self->unknown_rad < KNOWN_RAD));
}

void sd_twist_init(sd_twist_t *self, const sd_kalman_tables_t *t, const sd_kalman_choice_t *choice, sd_twist_sums_t *sums) {
    memset(self, 0, sizeof *self);
    (void)sd_kalman_init(&self->trial, t, choice);
    sums->deviation = sums->bias = 0.0f;
    sums->variance = (t->modes > 0u) ? PRIOR_SD * PRIOR_SD : 0.0f;
}

bool sd_twist_sums_ok(const sd_twist_sums_t *sums, const sd_kalman_tables_t *t) {
    const bool may_learn = (sums->variance > 0.0f) && (sums->variance <= 1.0f) && (sums->bias >= 0.0f) && (sums->bias <= 1.0f);
    return (within(sums->deviation, DEVIATION_MAX) == sums->deviation) && ((t->modes > 0u) ? may_learn : (sums->variance == 0.0f));
}
