/* SPDX-License-Identifier: MIT */
#include "sd_pattern.h"

#include <string.h>

#include "sd_teeth.h"

#define W_REF_RADPS 200.0f
#define SLOPE_MAX   1e-3f  /* rad per rad: the guess is good enough for the trend to be linear in it */
#define MODES_SETTLED 8u   /* cycles after which it is forgotten how the modes swung at the start */
#define SPREAD_MIN  0.05f  /* of u, relative: below it one speed only was seen */
#define MOTORED_SD  0.03f  /* of the motored torque, relative, while the speeds do not tell */

_Static_assert(sizeof(sd_pattern_t) == 4168, "without pointers, the same size on every target");

static void remove_mean(const sd_kalman_tables_t *t, float *values) {
    float sum = 0.0f, count = 0.0f;
    for (uint32_t k = 0; k < t->positions; ++k) {
        if (sd_kalman_has_tooth(t, k)) { sum += values[k]; count += 1.0f; }
    }
    for (uint32_t k = 0; k < t->positions; ++k) { values[k] = sd_kalman_has_tooth(t, k) ? values[k] - sum / count : 0.0f; }
}

/* The trend a_1 k + a_2 k^2 from the differences between the two revolutions. */
static void find_trend(const sd_kalman_tables_t *t, const float *difference_rad, float *a1, float *a2) {
    const float n = (float)t->positions;
    float level, slope;
    sd_teeth_line(t, difference_rad, &level, &slope);
    *a2 = slope / (2.0f * n);
    *a1 = level / n - 2.0f * n * *a2;
}

/* Each tooth's constant, and where the speeds tell, its slope over u; standard deviation from what the fit leaves. */
static void solve(sd_pattern_t *self, const sd_kalman_tables_t *t, float scale_nm) {
    const sd_pattern_sums_t *s = &self->sums;
    const float spread = 1.0f - s->u * s->u / (s->cycles * s->uu);
    self->pooled = (spread > SPREAD_MIN) ? 1u : 0u;
    float slope[SD_KALMAN_POSITIONS_MAX] = { 0 };
    for (uint32_t k = 0; k < t->positions; ++k) {
        self->late_rad[k] = s->late[k] / s->cycles;
        if (self->pooled == 0u) { continue; }
        self->late_rad[k] = (self->late_rad[k] - s->u / (s->cycles * s->uu) * s->late_u[k]) / spread;
        slope[k] = (s->late_u[k] - s->u * self->late_rad[k]) / s->uu;
    }
    float left = s->square - sd_teeth_mean_product(t, self->late_rad, s->late) - sd_teeth_mean_product(t, slope, s->late_u);
    left = ((left > 0.0f) ? left / (s->cycles - 2.0f) : 0.0f) + 1e-12f; /* 6e-5 deg: no wheel is known better */
    const float twist = (self->pooled != 0u) ? 0.0f : MOTORED_SD * self->ripple_nm / (4.0f * scale_nm);
    const float effective = (self->pooled != 0u) ? s->cycles * spread : s->cycles;
    const float variance = left / effective + twist * twist;
    self->sd_rad = variance * sd_rsqrt_f32(variance);
}

static void add_cycle(sd_pattern_t *self, const sd_kalman_tables_t *t, float a1, float a2, float square_speed) {
    float late[SD_KALMAN_POSITIONS_MAX];
    const float n = (float)t->positions, u = W_REF_RADPS * W_REF_RADPS / square_speed;
    for (uint32_t k = 0; k < t->positions; ++k) {
        const float at = (float)k, next = at + n;
        late[k] = 0.5f * (self->cycle_rad[k] + self->cycle_rad[k + t->positions] - a1 * (at + next) -
                          a2 * (at * at + next * next));
    }
    remove_mean(t, late);
    for (uint32_t k = 0; k < t->positions; ++k) {
        self->sums.late[k] += late[k];
        self->sums.late_u[k] += u * late[k];
    }
    self->sums.cycles += 1.0f;
    self->sums.u += u;
    self->sums.uu += u * u;
    self->sums.square += sd_teeth_mean_product(t, late, late);
}

/* All teeth of a cycle are in: learn from it when the guess was good, and better the guess. */
static bool end_cycle(sd_pattern_t *self, const sd_kalman_tables_t *t) {
    const float pitch = 6.2831853f / (float)t->positions;
    float a1 = 0.0f, a2 = 0.0f;
    float difference[SD_KALMAN_POSITIONS_MAX];
    for (uint32_t k = 0; k < t->positions; ++k) { difference[k] = self->cycle_rad[k + t->positions] - self->cycle_rad[k]; }
    const bool settled = self->guessed >= ((t->modes > 0u) ? MODES_SETTLED : 2u);
    if (settled) { sd_twist_learn(&self->twist, t, &self->sums.twist, difference, &self->free); }
    find_trend(t, difference, &a1, &a2);
    const float slope = a1 / pitch, bend = a2 / (pitch * pitch); /* a rad */
    const float square_speed = 2.0f * self->energy_j / t->inertia_mean_kgm2;
    const bool good = settled && (slope < SLOPE_MAX) && (slope > -SLOPE_MAX) && sd_twist_known(&self->twist, t);
    if (good) { add_cycle(self, t, a1, a2, square_speed); }
    /* L' = -de / (2 e), and de grows by the constant torque's error. */
    const float constant = -4.0f * bend * self->energy_j;
    const float cycle_rad = 12.566371f;
    self->energy_j = self->free.energy_j - 2.0f * slope * self->energy_j + constant * cycle_rad;
    self->constant_nm += constant;
    if (self->guessed < 255u) { self->guessed++; }
    if (!good || (self->sums.cycles < (float)SD_PATTERN_CYCLES_MIN)) { return false; }
    solve(self, t, t->inertia_mean_kgm2 * square_speed);
    return true;
}

/* Rms of the motored torque; *free has no other. */
static float ripple(const sd_kalman_t *free, const sd_kalman_tables_t *t) {
    float square = 1e-6f;
    for (uint32_t k = 0; k < 2u * t->positions; ++k) {
        const float torque = sd_kalman_torque(free, t, k);
        square += torque * torque / (float)(2u * t->positions);
    }
    return square * sd_rsqrt_f32(square);
}

/* The prediction begins anew; the modes swing on. */
static void restart_free(sd_pattern_t *self) {
    const sd_kalman_t before = self->free;
    sd_kalman_restart(&self->free);
    memcpy(self->free.twist_rad, before.twist_rad, sizeof before.twist_rad);
    memcpy(self->free.swing_rad, before.swing_rad, sizeof before.swing_rad);
}

/* From tooth 0: the free prediction starts with no lateness. */
static void begin_cycle(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    if (self->guessed == 0u) {
        const float speed = 6.2831853f / (float)t->positions * t->tick_hz * (float)tooth->advance / (float)tooth->period_ticks;
        self->energy_j = 0.5f * t->inertia_tooth_kgm2[0] * speed * speed;
        self->constant_nm = 0.0f;
        self->guessed = 1;
    }
    restart_free(self);
    sd_kalman_set_intake(&self->free, tooth->intake_bar);
    self->ripple_nm = ripple(&self->free, t);
    self->free.running = 1;
    self->free.energy_j = self->energy_j;
    self->free.coefficient_nm[0] = self->constant_nm;
    self->free.lateness_s = sd_kalman_late(&self->free, t, 0) * sd_rsqrt_f32(2.0f * self->energy_j / t->inertia_tooth_kgm2[0]);
    sd_twist_begin(&self->twist, t, &self->free);
    self->cycle_rad[0] = 0.0f;
    self->teeth = 1;
    self->following = 1;
}

static void follow(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    sd_kalman_tooth_t predicted = *tooth;
    sd_firing_t unused;
    predicted.trusted = 0;
    sd_kalman_step(&self->free, t, &predicted, &unused);
    if (self->free.running == 0u) { sd_pattern_pause(self); return; }
    const uint32_t k = tooth->cycle_position;
    self->cycle_rad[k] = sd_kalman_late(&self->free, t, k);
    sd_twist_follow(&self->twist, t, &predicted, self->cycle_rad[k]);
    self->teeth++;
}

bool sd_pattern_step(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    if ((tooth->trusted == 0u) || (tooth->cycle_position >= 2u * t->positions) || (tooth->period_ticks == 0u) ||
        !((tooth->intake_bar >= 0.0f) && (tooth->intake_bar <= 10.0f))) {
        sd_pattern_pause(self);
        return false;
    }
    bool changed = false;
    if (self->following != 0u) {
        follow(self, t, tooth);
        /* Tooth 0 again: its lateness closes the cycle, but belongs to the next one. */
        if ((self->following != 0u) && (tooth->cycle_position == 0u) && ((float)self->teeth == 2.0f * sd_teeth_count(t) + 1.0f)) {
            self->cycle_rad[0] = 0.0f;
            changed = end_cycle(self, t);
        }
    }
    if (tooth->cycle_position == 0u) { begin_cycle(self, t, tooth); }
    return changed;
}

bool sd_pattern_take_zero(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_firing_t *firing, float charge_bar,
                          float speed_radps) {
    const float u = W_REF_RADPS * W_REF_RADPS / (speed_radps * speed_radps), weight = u * u;
    if ((firing->index >= t->firings) || !(charge_bar > 0.05f) || !(weight < 1e4f)) { return false; }
    self->sums.zero[firing->index] += weight * firing->raw_nm / charge_bar;
    self->sums.zero_u2[firing->index] += weight;
    return firing->index == (t->firings - 1u);
}

void sd_pattern_zeros(const sd_pattern_t *self, const sd_kalman_tables_t *t, float *zero_nm_per_bar) {
    float mean = 0.0f;
    memset(zero_nm_per_bar, 0, SD_KALMAN_FIRINGS_MAX * sizeof *zero_nm_per_bar);
    for (uint32_t i = 0; i < t->firings; ++i) {
        if (!(self->sums.zero_u2[i] > 0.0f)) { return; }
        mean += self->sums.zero[i] / self->sums.zero_u2[i] / (float)t->firings;
    }
    for (uint32_t i = 0; i < t->firings; ++i) { zero_nm_per_bar[i] = self->sums.zero[i] / self->sums.zero_u2[i] - mean; }
}

void sd_pattern_pause(sd_pattern_t *self) {
    self->following = 0;
    self->guessed = 0;
}

void sd_pattern_init(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_kalman_choice_t *choice) {
    memset(self, 0, sizeof *self);
    (void)sd_kalman_init(&self->free, tables, choice);
    sd_twist_init(&self->twist, tables, choice, &self->sums.twist);
}

sd_result_t sd_pattern_resume(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_pattern_sums_t *sums) {
    const float *value = (const float *)sums;
    for (uint32_t i = 0; i < sizeof *sums / sizeof *value; ++i) {
        if (!((value[i] > -1e9f) && (value[i] < 1e9f))) { return SD_ERR_CONFIG; }
    }
    if (!(sums->cycles >= 0.0f) || !(sums->uu >= 0.0f) || !(sums->square >= 0.0f)) { return SD_ERR_CONFIG; }
    for (uint32_t k = 0; k < tables->positions; ++k) {
        if (!sd_kalman_has_tooth(tables, k) && (sums->late[k] != 0.0f)) { return SD_ERR_CONFIG; }
    }
    if (!sd_twist_sums_ok(&sums->twist, tables)) { return SD_ERR_CONFIG; }
    self->sums = *sums;
    sd_twist_tune(&self->sums.twist, &self->free);
    sd_kalman_restart(&self->free);
    self->ripple_nm = ripple(&self->free, tables);
    if (sums->cycles < (float)SD_PATTERN_CYCLES_MIN) { return SD_OK; }
    solve(self, tables, tables->inertia_mean_kgm2 * W_REF_RADPS * W_REF_RADPS * sums->cycles / sums->u);
    return SD_OK;
}
