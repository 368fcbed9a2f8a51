/* SPDX-License-Identifier: MIT */
/* The part of sd_motion that each tooth takes, for sd_motion.c and for the filter, which pays for no call; no part of its
 * interface. */
#ifndef SD_MOTION_INLINE_H
#define SD_MOTION_INLINE_H
#include "sd_motion.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { MEAN, MOMENT, POINT, BEND, PULSE_WORDS = 6 }; /* of a pulse; BEND: the same three of its bend begin */

static inline const sd_kalman_word_t *pulses_of(const sd_kalman_tables_t *t, const sd_kalman_word_t *word) {
    return word + SD_ROW_MOTORED + 3u * t->cylinders;
}

static inline const sd_kalman_word_t *modes_of(const sd_kalman_tables_t *t, const sd_kalman_word_t *word) {
    return pulses_of(t, word) + PULSE_WORDS * t->window;
}

/* Twist that the known torques of a row hold, of mode m. */
float sd_motion_held_by_known(const sd_kalman_tables_t *t, const sd_kalman_word_t *word, uint32_t m, const sd_motion_charge_t *charge);

/* The modes over an interval of dt at a speed squared. Returns true. Apart, so that a rigid crank does not pay for the
 * registers that it takes. */
bool sd_motion_swing(sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row, float shape,
                     const sd_motion_tuning_t *tuning,
                     float dt, float square);

/* As sd_motion_known. Returns the known torque at tooth k itself. */
static inline float sd_motion_sum_known(const sd_kalman_tables_t *t, uint32_t k, const sd_motion_charge_t *charge,
                                        sd_motion_row_t *row) {
    const sd_kalman_word_t *word = sd_motion_word(t, k), *motored = word + SD_ROW_MOTORED;
    const float common = charge->common_bar, *bar = charge->charge_bar;
    float mean = word[SD_ROW_KNOWN + MEAN].value + word[SD_ROW_COMMON + MEAN].value * common;
    float moment = word[SD_ROW_KNOWN + MOMENT].value + word[SD_ROW_COMMON + MOMENT].value * common;
    float point = word[SD_ROW_KNOWN + POINT].value + word[SD_ROW_COMMON + POINT].value * common;
    _Pragma("GCC unroll 4")
    for (uint32_t left = t->cylinders; left > 0u; --left, motored += 3, ++bar) {
        mean += motored[MEAN].value * *bar;
        moment += motored[MOMENT].value * *bar;
        point += motored[POINT].value * *bar;
    }
    row->word = word;
    row->mean_nm = mean;
    row->moment_nm = moment;
    for (uint32_t m = 0; m < t->modes; ++m) { row->held_rad[m] = sd_motion_held_by_known(t, word, m, charge); }
    return point;
}

/* As sd_motion_predict. */
static inline bool sd_motion_move(sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row, float shape,
                                  const sd_motion_tuning_t *tuning) {
    const sd_kalman_word_t *pulse = pulses_of(t, row->word);
    const float *x = self->coefficient_nm;
    float mean = row->mean_nm + x[0], moment = row->moment_nm + 0.5f * x[0];
    uint32_t j = 1u + row->word[SD_ROW_AT].at.first;
    for (uint32_t left = t->window; left > 0u; --left, pulse += PULSE_WORDS) {
        mean += (pulse[MEAN].value + shape * pulse[BEND + MEAN].value) * x[j];
        moment += (pulse[MOMENT].value + shape * pulse[BEND + MOMENT].value) * x[j];
        j = (j + 1u < t->coefficients) ? j + 1u : 1u;
    }
    const float pitch = t->pitch_rad, middle = self->energy_j + pitch * moment, least = sd_motion_energy_min(t);
    self->energy_j += pitch * mean;
    if (!(middle > least) || !(self->energy_j > least)) { return false; }
    const float square = middle * row->word[SD_ROW_INTERVAL].value, dt = pitch / sd_sqrt_f32(square);
    self->lateness_s += dt;
    return (t->modes == 0u) || sd_motion_swing(self, t, row, shape, tuning, dt, square);
}

#ifdef __cplusplus
}
#endif

#endif
