/* SPDX-License-Identifier: MIT */
#include "sd_twist.h"

#include <string.h>

#define STEP          2e-3f /* share by which the trial is faster */
#define PRIOR_SD      0.05f /* 10 % of stiffness */
#define MODEL_RAD     5e-5f /* rms of the differences that an error of the model makes, 0.003 deg */
#define WALK          1e-5f /* springs age, a cycle */
#define MOVE_MAX      0.01f /* in one cycle */
#define DEVIATION_MAX 0.1f
#define CURVATURE     1.0f  /* of a step, squared, that is left to learn anew */
#define KNOWN_RAD     1e-4f
#define SHARE_MAX     1e4f   /* rad, of a sensitivity: beyond it the trial went astray */
#define RAD2_MAX      100.0f /* beyond it, it is no crank that turns */

float sd_twist_sd(const sd_twist_sums_t *sums) { return sd_root(sums->variance + sums->bias * sums->bias); }

static sd_motion_tuning_t tuning_of(float ratio) { return (sd_motion_tuning_t){ ratio, 1.0f / ratio, 1.0f / (ratio * ratio) }; }

sd_motion_tuning_t sd_twist_tuning(const sd_twist_sums_t *sums) { return tuning_of(1.0f + sums->deviation); }

void sd_twist_begin(sd_twist_t *self, const sd_kalman_tables_t *t, const sd_motion_t *free, const sd_motion_tuning_t *tuning) {
    if (t->modes == 0u) { return; }
    float twist[SD_KALMAN_MODES_MAX], swing[SD_KALMAN_MODES_MAX];
    memcpy(twist, self->trial.twist_rad, sizeof twist);
    memcpy(swing, self->trial.swing_rad, sizeof swing);
    self->trial = *free;
    memcpy(self->trial.twist_rad, twist, sizeof twist);
    memcpy(self->trial.swing_rad, swing, sizeof swing);
    self->tuning = tuning_of(tuning->frequency * (1.0f + STEP));
}

bool sd_twist_predict(sd_twist_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row) {
    return (t->modes == 0u) || sd_motion_predict(&self->trial, t, row, 0.0f, &self->tuning);
}

void sd_twist_follow(sd_twist_t *self, const sd_kalman_tables_t *t, uint32_t k, float period_s, float late_rad, float d,
                     sd_teeth_sums_t *pairs) {
    if (t->modes == 0u) { return; }
    const float square = self->trial.energy_j * sd_motion_word(t, k)[SD_ROW_TOOTH].value, speed = sd_sqrt_f32(square);
    self->trial.lateness_s -= period_s;
    const float share = (sd_motion_late(&self->trial, t, speed, &self->tuning) - late_rad) * (1.0f / STEP);
    if (!sd_within(share, -SHARE_MAX, SHARE_MAX)) { memset(&self->trial, 0, sizeof self->trial); } /* and the cycle says so by its sums */
    if (k < t->positions) { self->sensitivity_rad[k] = share; return; }
    const uint32_t tooth = k - t->positions;
    const float s = share - self->sensitivity_rad[tooth], at = (float)tooth - 0.5f * (float)t->positions;
    pairs->s += s;
    pairs->ks += at * s;
    pairs->ss += s * s;
    pairs->sd += s * d;
}

/* The modes would swing otherwise by now. */
static void carry_on(sd_twist_t *self, const sd_kalman_tables_t *t, float move, sd_motion_t *free) {
    for (uint32_t m = 0; m < t->modes; ++m) {
        const float twist = (self->trial.twist_rad[m] - free->twist_rad[m]) * (move / STEP);
        const float swing = (self->trial.swing_rad[m] - free->swing_rad[m]) * (move / STEP);
        free->twist_rad[m] += twist, self->trial.twist_rad[m] += twist;
        free->swing_rad[m] += swing, self->trial.swing_rad[m] += swing;
    }
}

void sd_twist_learn(sd_twist_t *self, const sd_kalman_tables_t *t, sd_twist_sums_t *sums, sd_teeth_sums_t *pairs, sd_motion_t *free) {
    if (t->modes == 0u) { return; }
    /* Mean products of d and s, each less its line of least squares. */
    float d_level, d_slope, s_level, s_slope;
    sd_teeth_line(pairs, pairs->d, pairs->kd, &d_level, &d_slope);
    sd_teeth_line(pairs, pairs->s, pairs->ks, &s_level, &s_slope);
    const float ss = sd_clamp((pairs->ss - s_level * pairs->s - s_slope * pairs->ks) / pairs->count, 0.0f, RAD2_MAX) + 1e-12f;
    const float sd = (pairs->sd - s_level * pairs->d - s_slope * pairs->kd) / pairs->count;
    const float dd = (pairs->dd - d_level * pairs->d - d_slope * pairs->kd) / pairs->count;
    if (!(ss < RAD2_MAX) || !(dd < RAD2_MAX)) { return; }
    const float left = dd - sd * sd / ss;
    const float jitter = ((left > 0.0f) ? left / (pairs->count - 3.0f) : 0.0f) / ss, bias = MODEL_RAD * sd_root(1.0f / ss);
    /* An error of the model does not average out: where it moves the frequency further than that is known, nothing is learned. */
    const bool tells = bias < sd_twist_sd(sums);
    const float gain = tells ? sums->variance / (sums->variance + jitter + bias * bias) : 0.0f, before = sums->deviation;
    sums->deviation = sd_clamp(before - sd_clamp(gain * sd / ss, -MOVE_MAX, MOVE_MAX), -DEVIATION_MAX, DEVIATION_MAX);
    const float move = sums->deviation - before;
    sums->variance += WALK * WALK + CURVATURE * move * move - gain * sums->variance;
    sums->bias += gain * (bias - sums->bias);
    self->unknown_rad = sd_twist_sd(sums) * sd_root(ss);
    pairs->d += move * pairs->s;
    pairs->kd += move * pairs->ks;
    carry_on(self, t, move, free);
}

bool sd_twist_known(const sd_twist_t *self, const sd_kalman_tables_t *t) {
    return (t->modes == 0u) || ((self->unknown_rad > 0.0f) && (self->unknown_rad < KNOWN_RAD));
}

void sd_twist_init(sd_twist_t *self, const sd_kalman_tables_t *t, sd_twist_sums_t *sums) {
    memset(self, 0, sizeof *self);
    sums->deviation = sums->bias = 0.0f;
    sums->variance = (t->modes > 0u) ? PRIOR_SD * PRIOR_SD : 0.0f;
}

bool sd_twist_sums_ok(const sd_twist_sums_t *sums, const sd_kalman_tables_t *t) {
    const bool may_learn = (sums->variance > 0.0f) && (sums->variance <= 1.0f) && (sums->bias >= 0.0f) && (sums->bias <= 1.0f);
    return sd_within(sums->deviation, -DEVIATION_MAX, DEVIATION_MAX) && ((t->modes > 0u) ? may_learn : (sums->variance == 0.0f));
}
