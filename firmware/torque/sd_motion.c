/* SPDX-License-Identifier: MIT */
#include "sd_motion_inline.h"

static const float INVERSE[6] = { 1.0f, 0.5f, 1.0f / 3.0f, 0.25f, 0.2f, 1.0f / 6.0f };

uint32_t sd_motion_gains_at(const sd_kalman_tables_t *t) {
    return SD_ROW_MOTORED + 3u * t->cylinders + PULSE_WORDS * t->window + 2u * t->modes;
}

uint32_t sd_motion_row_words(const sd_kalman_tables_t *t) {
    return sd_motion_gains_at(t) + ((uint32_t)t->sets * t->speeds * sd_motion_columns(t) + 2u) / 2u;
}

uint32_t sd_kalman_pool_used(const sd_kalman_tables_t *t) {
    const uint32_t parts = t->parts;
    return 2u * t->positions * sd_motion_row_words(t) + parts * t->positions + parts * parts + t->hidden * sd_motion_hidden_words(t);
}

/* ---- charges --------------------------------------------------------------------------------------------------- */

void sd_motion_set_exponent(sd_motion_charge_t *charge, const sd_kalman_tables_t *t, float exponent) {
    float sum = 0.0f;
    for (uint32_t i = 0; i < t->cylinders; ++i) { sum += charge->charge_bar[i]; }
    charge->exponent = exponent;
    charge->common_bar = exponent * sum / (float)t->cylinders;
}

void sd_motion_fill(sd_motion_charge_t *charge, float intake_bar) {
    charge->intake_bar = intake_bar;
    for (uint32_t i = 0; i < SD_KALMAN_FIRINGS_MAX; ++i) { charge->charge_bar[i] = intake_bar; }
    charge->common_bar = charge->exponent * intake_bar;
}

void sd_motion_close_valves(sd_motion_charge_t *charge, const sd_kalman_tables_t *t, const sd_kalman_word_t *word) {
    uint32_t closing = word[SD_ROW_AT].at.close;
    for (uint32_t i = 0; closing != 0u; ++i, closing >>= 1) {
        if ((closing & 1u) != 0u) { charge->charge_bar[i] = charge->intake_bar; }
    }
    if (charge->exponent != 0.0f) { sd_motion_set_exponent(charge, t, charge->exponent); }
}

/* ---- prediction ------------------------------------------------------------------------------------------------ */

/* Twist that the known torques of a row hold, of mode m. */
float sd_motion_held_by_known(const sd_kalman_tables_t *t, const sd_kalman_word_t *word, uint32_t m, const sd_motion_charge_t *charge) {
    const sd_kalman_word_t *motored = word + SD_ROW_MOTORED;
    float held = modes_of(t, word)[2u * m].value;
    for (uint32_t i = 0; i < t->cylinders; ++i, motored += 3) {
        held += t->mode[m].cylinder_radpnm[i] * motored[MEAN].value * charge->charge_bar[i];
    }
    return held;
}

void sd_motion_known(const sd_kalman_tables_t *t, uint32_t k, const sd_motion_charge_t *charge, sd_motion_row_t *row) {
    (void)sd_motion_sum_known(t, k, charge, row);
}

/* exp(x A) = a I + b A with A = [0 1; -1 -2 z], for x >= 0: Taylor's series at a small part of x, then squared, both by
 * A^2 = -I - 2 z A. */
static void exponential(float x, float z, float *a, float *b) {
    uint32_t halvings = 0;
    while ((x > 0.5f) && (halvings < 10u)) { x *= 0.5f; halvings++; }
    float term_a = 1.0f, term_b = 0.0f;
    *a = 1.0f, *b = 0.0f;
    for (uint32_t n = 0; n < 6u; ++n) { /* left out: 0.5^7 / 7! = 1.6e-6 */
        const float next_a = -term_b, step = x * INVERSE[n];
        term_b = (term_a - 2.0f * z * term_b) * step;
        term_a = next_a * step;
        *a += term_a, *b += term_b;
    }
    for (; halvings > 0u; --halvings) {
        const float square_b = *b * *b;
        *b = 2.0f * *a * *b - 2.0f * z * square_b;
        *a = *a * *a - square_b;
    }
}

/* The twist that the mean torques of an interval would hold, of mode m; firing j is cylinder j where there are modes. */
static float held_twist(const sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row, uint32_t m, float shape,
                        float square) {
    const sd_kalman_mode_t *mode = &t->mode[m];
    const sd_kalman_word_t *pulse = pulses_of(t, row->word);
    float held = row->held_rad[m] + modes_of(t, row->word)[2u * m + 1u].value * square + mode->constant_radpnm * self->coefficient_nm[0];
    uint32_t j = row->word[SD_ROW_AT].at.first;
    for (uint32_t left = t->window; left > 0u; --left, pulse += PULSE_WORDS) {
        held += mode->cylinder_radpnm[j] * (pulse[MEAN].value + shape * pulse[BEND + MEAN].value) * self->coefficient_nm[1u + j];
        j = (j + 1u < t->cylinders) ? j + 1u : 0u;
    }
    return held;
}

bool sd_motion_swing(sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row, float shape,
                     const sd_motion_tuning_t *tuning,
                     float dt, float square) {
    for (uint32_t m = 0; m < t->modes; ++m) {
        const float held = tuning->compliance * held_twist(self, t, row, m, shape, square), away = self->twist_rad[m] - held,
            v = self->swing_rad[m];
        const float z = t->mode[m].damping;
        float a, b;
        exponential(tuning->frequency * t->mode[m].frequency_radps * dt, z, &a, &b);
        self->twist_rad[m] = held + a * away + b * v;
        self->swing_rad[m] = a * v - b * (away + 2.0f * z * v);
    }
    return true;
}

bool sd_motion_predict(sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row, float shape,
                       const sd_motion_tuning_t *tuning) {
    return sd_motion_move(self, t, row, shape, tuning);
}

float sd_motion_ahead(const sd_motion_t *self, const sd_kalman_tables_t *t, float speed, const sd_motion_tuning_t *tuning) {
    float twist = 0.0f, rate = 0.0f;
    for (uint32_t m = 0; m < t->modes; ++m) {
        twist += self->twist_rad[m];
        rate += self->swing_rad[m] * (tuning->frequency * t->mode[m].frequency_radps);
    }
    return twist * (1.0f - rate / speed);
}

/* What a dual-mass flywheel takes from the crank beyond the constant torque. */
static float through_spring(const sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_tuning_t *tuning) {
    const float r = tuning->frequency;
    float torque = 0.0f;
    for (uint32_t m = 0; m < t->modes; ++m) {
        torque += r * t->mode[m].spring_nmprad * self->twist_rad[m] + t->mode[m].damper_nmprad * self->swing_rad[m];
    }
    return r * torque;
}

float sd_motion_torque(const sd_motion_t *self, const sd_kalman_tables_t *t, uint32_t k, float known_nm, float shape,
                       const sd_motion_tuning_t *tuning) {
    const sd_kalman_word_t *word = sd_motion_word(t, k), *pulse = pulses_of(t, word);
    float sum = known_nm + self->coefficient_nm[0];
    uint32_t j = 1u + word[SD_ROW_AT].at.first;
    for (uint32_t left = t->window; left > 0u; --left, pulse += PULSE_WORDS) {
        sum += (pulse[POINT].value + shape * pulse[BEND + POINT].value) * self->coefficient_nm[j];
        j = (j + 1u < t->coefficients) ? j + 1u : 1u;
    }
    return (t->modes != 0u) ? sum - through_spring(self, t, tuning) : sum;
}
