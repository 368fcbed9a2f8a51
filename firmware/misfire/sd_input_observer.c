/* SPDX-License-Identifier: MIT */
#include "sd_input_observer.h"

#include <string.h>

#include "sd_math.h"

enum { REJECTED_IN_ROW_MAX = 12 };

static uint32_t states(const sd_input_observer_t *self) { return 2u + self->cylinders; }

/* x+ = F x along one row or column of the covariance, or for the state itself: `at` in strides. */
static void transform(const sd_input_observer_t *self, const float *input, float *x, uint32_t stride) {
    float drive = 0.0f;
    for (uint32_t n = 0; n < self->cylinders; ++n) { drive += input[n] * x[(n + 2u) * stride]; }
    const float v1 = x[0], v2 = x[stride];
    x[0]      = v1 + (self->increment[0][0] * v1 + self->increment[0][1] * v2 + self->from_input[0] * drive);
    x[stride] = v2 + (self->increment[1][0] * v1 + self->increment[1][1] * v2 + self->from_input[1] * drive);
}

static void predict(sd_input_observer_t *self, const float *input) {
    const uint32_t n = states(self);
    transform(self, input, self->state, 1u);
    for (uint32_t j = 0; j < n; ++j) { transform(self, input, &self->covariance[0][j], SD_INPUT_STATES_MAX); }
    for (uint32_t i = 0; i < n; ++i) { transform(self, input, self->covariance[i], 1u); }
    for (uint32_t i = 2; i < n; ++i) { self->covariance[i][i] += self->walk_variance; }
}

/* Two samples in a row beyond the limit on the same side: one alone may be noise. What then changed is the strength of
 * the active cylinder while its input acts, and the crank itself where nothing else could have. */
static void watch(sd_input_observer_t *self, float squared, const float *input, uint32_t active) {
    const int8_t side = (squared <= self->alarm_squared) ? 0 : (self->innovation > 0.0f) ? 1 : -1;
    if ((side != 0) && (side == self->last_side)) {
        if (input[active] != 0.0f) {
            self->covariance[active + 2u][active + 2u] += 1.0f;
        } else {
            self->covariance[1][1] += self->start_variance[1];
        }
        if (self->alarms < UINT32_MAX) { self->alarms++; }
    }
    self->last_side = side;
}

/* Kalman update, y sees state 0: P <- (I - K h) P (I - K h)' + K R K', symmetric and positive whatever rounding does. */
static void correct(sd_input_observer_t *self, float y, const float *input, uint32_t active) {
    const uint32_t n = states(self);
    const float variance = self->covariance[0][0] + self->noise_variance;
    self->innovation = y - self->state[0];
    const float squared = self->innovation * self->innovation / variance;
    self->test_ratio = sd_root(squared / self->alarm_squared);
    watch(self, squared, input, active);
    float gain[SD_INPUT_STATES_MAX], seen[SD_INPUT_STATES_MAX];
    for (uint32_t i = 0; i < n; ++i) {
        seen[i] = self->covariance[0][i];
        gain[i] = seen[i] / variance;
        self->state[i] += gain[i] * self->innovation;
    }
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j <= i; ++j) {
            const float p = self->covariance[i][j] - gain[i] * seen[j] - gain[j] * seen[i] + gain[i] * gain[j] * variance;
            self->covariance[i][j] = self->covariance[j][i] = p;
        }
    }
}

static bool below(float x, float limit) { return (x > -limit) && (x < limit); } /* false for NaN */

/* Nothing is used that is not finite, and no variance that is not positive. */
static bool sound(const sd_input_observer_t *self) {
    bool fine = true;
    for (uint32_t i = 0; i < states(self); ++i) {
        fine = fine && below(self->state[i], 1e9f) && (self->covariance[i][i] > 0.0f) && (self->covariance[i][i] < 1e18f);
    }
    return fine;
}

static bool inputs_sound(const sd_input_observer_t *self, const float *input) {
    bool fine = true;
    for (uint32_t n = 0; n < self->cylinders; ++n) { fine = fine && below(input[n], 1e9f); }
    return fine;
}

static void stop(sd_input_observer_t *self) {
    memset(self->state, 0, sizeof self->state);
    self->running = 0;
    self->steps = 0;
    self->rejected_in_row = 0;
}

static void count_rejected(sd_input_observer_t *self) {
    if (self->rejected < UINT16_MAX) { self->rejected++; }
    self->rejected_in_row++;
}

void sd_input_start(sd_input_observer_t *self, float speed_mps, float accel_mps2, const float *strength) {
    stop(self);
    memset(self->covariance, 0, sizeof self->covariance);
    self->innovation = self->test_ratio = 0.0f;
    self->alarms = 0;
    self->last_side = 0;
    self->state[0] = speed_mps;
    self->state[1] = accel_mps2;
    for (uint32_t i = 0; i < states(self); ++i) {
        if (i >= 2u) { self->state[i] = (strength != NULL) ? strength[i - 2u] : 1.0f; }
        self->covariance[i][i] = self->start_variance[(i < 2u) ? i : 2u];
    }
    if (sound(self)) { self->running = 1; } else { stop(self); }
}

float sd_input_step(sd_input_observer_t *self, float y_mps, const float *input_mps3, uint8_t active) {
    const bool good = below(y_mps, 1e9f);
    const bool usable = inputs_sound(self, input_mps3) && (active < self->cylinders);
    if (!good || !usable) { count_rejected(self); } else { self->rejected_in_row = 0; }
    if (self->running == 0u) {
        if (good && usable) { sd_input_start(self, y_mps, 0.0f, NULL); }
        return 0.0f;
    }
    if (!usable || (self->rejected_in_row > REJECTED_IN_ROW_MAX)) {
        stop(self);
        return 0.0f;
    }
    predict(self, input_mps3);
    if (good) { correct(self, y_mps, input_mps3, active); }
    if (!sound(self)) { stop(self); }
    if (self->steps < UINT32_MAX) { self->steps++; }
    return self->state[1];
}

void sd_input_read(const sd_input_observer_t *self, sd_input_estimate_t *estimate) {
    memset(estimate, 0, sizeof *estimate);
    sd_status_t *status = &estimate->status;
    status->rejected = self->rejected;
    if (self->running == 0u) {
        status->health = SD_INVALID;
        status->why = SD_WHY_CONVERGING;
        return;
    }
    estimate->speed_mps = self->state[0];
    estimate->accel_mps2 = self->state[1];
    estimate->accel_sd_mps2 = sd_root(self->covariance[1][1]);
    for (uint32_t n = 0; n < self->cylinders; ++n) {
        estimate->strength[n] = self->state[n + 2u];
        estimate->strength_sd[n] = sd_root(self->covariance[n + 2u][n + 2u]);
    }
    status->innovation = self->innovation;
    status->test_ratio = self->test_ratio;
    if (self->steps < self->settle_steps) {
        status->health = SD_DEGRADED;
        status->why = SD_WHY_CONVERGING;
    } else if (self->rejected_in_row > 0u) {
        status->health = SD_DEGRADED;
        status->why = SD_WHY_REJECTED;
    }
}

sd_result_t sd_input_init(sd_input_observer_t *self, const sd_input_config_t *config) {
    bool fine = (config->cylinders >= 1u) && (config->cylinders <= SD_INPUT_CYLINDERS_MAX) &&
                sd_above_to(config->noise_mps, 0.0f, 100.0f) && sd_above_to(config->start_speed_mps, 0.0f, 1e3f) &&
                sd_above_to(config->start_accel_mps2, 0.0f, 1e5f) && sd_above_to(config->start_strength, 0.0f, 1.0f) &&
                (config->walk_strength >= 0.0f) && (config->walk_strength <= 1.0f) && (config->alarm_sd >= 3.0f) &&
                (config->alarm_sd <= 100.0f);
    for (uint32_t i = 0; i < 2u; ++i) {
        fine = fine && below(config->step->increment[i][0], 1e6f) && below(config->step->increment[i][1], 1e6f) &&
               below(config->step->from_input[i], 1e6f);
    }
    if (!fine) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    memcpy(self->increment, config->step->increment, sizeof self->increment);
    memcpy(self->from_input, config->step->from_input, sizeof self->from_input);
    self->cylinders = config->cylinders;
    self->settle_steps = config->settle_steps;
    self->noise_variance = config->noise_mps * config->noise_mps;
    self->start_variance[0] = config->start_speed_mps * config->start_speed_mps;
    self->start_variance[1] = config->start_accel_mps2 * config->start_accel_mps2;
    self->start_variance[2] = config->start_strength * config->start_strength;
    self->walk_variance = config->walk_strength * config->walk_strength;
    self->alarm_squared = config->alarm_sd * config->alarm_sd;
    return SD_OK;
}
