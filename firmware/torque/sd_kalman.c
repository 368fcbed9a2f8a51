/* SPDX-License-Identifier: MIT */
#include "sd_kalman.h"

#include <string.h>

#define TWO_PI 6.2831853f

_Static_assert(sizeof(sd_kalman_t) == 476, "without pointers, the same size on every target");

enum { REJECTED_IN_ROW_MAX = 12, /* teeth left out in a row after which the estimate itself must be wrong */
       SPEED_MIN_RADPS = 5 };

/* Where a speed lies among the gain tables of the filter's set: between `at` and the next one, `share` of the way. */
typedef struct sd_between {
    uint32_t at, next;
    float    share;
} sd_between_t;

static sd_between_t find_speed(const sd_kalman_t *self, const sd_kalman_tables_t *t, float speed) {
    sd_between_t b = { 0, 0, 0.0f };
    while ((b.at + 1u < t->speeds) && (speed >= t->speed_radps[b.at + 1u])) { b.at++; }
    b.next = b.at;
    if ((b.at + 1u < t->speeds) && (speed > t->speed_radps[b.at])) {
        b.next = b.at + 1u;
        b.share = (speed - t->speed_radps[b.at]) / (t->speed_radps[b.next] - t->speed_radps[b.at]);
    }
    const uint32_t set = (self->set < t->sets) ? self->set : 0u;
    b.at += set * t->speeds;
    b.next += set * t->speeds;
    return b;
}

static float blend(const float *table, sd_between_t b) {
    return table[b.at] + b.share * (table[b.next] - table[b.at]);
}

static uint32_t row_size(const sd_kalman_tables_t *t) {
    return 3u * (t->coefficients - 1u) + (uint32_t)t->sets * t->speeds * (t->coefficients + 2u);
}

uint32_t sd_kalman_pool_used(const sd_kalman_tables_t *tables) { return 2u * tables->positions * row_size(tables); }

static const float *row_of(const sd_kalman_tables_t *t, uint32_t k) { return &t->pool[k * row_size(t)]; }

static const float *gains_of(const sd_kalman_tables_t *t, uint32_t k, uint32_t speed) {
    return row_of(t, k) + 3u * (t->coefficients - 1u) + speed * (t->coefficients + 2u);
}

enum { MEAN, MOMENT, POINT };

/* T by one of the three tables; `whole` is what a constant torque has there. */
static float torque_by(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k, uint32_t which, float whole) {
    const uint32_t count = t->coefficients - 1u;
    const float *f = row_of(t, k) + which * count;
    float sum = t->known[which][k] + self->intake_bar * t->known_per_bar[which][k] + whole * self->coefficient_nm[0];
    for (uint32_t j = 0; j < count; ++j) { sum += f[j] * self->coefficient_nm[1u + j]; }
    return sum;
}

static float pitch_of(const sd_kalman_tables_t *t) { return TWO_PI / (float)t->positions; }

static float energy_min(const sd_kalman_tables_t *t) {
    return 0.5f * t->inertia_mean_kgm2 * (float)(SPEED_MIN_RADPS * SPEED_MIN_RADPS);
}

/* Over the interval that ends at cycle position k. False when the crank would stand still in it. */
static bool predict(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k) {
    const float pitch = pitch_of(t);
    const float middle = self->energy_j + pitch * torque_by(self, t, k, MOMENT, 0.5f);
    self->energy_j += pitch * torque_by(self, t, k, MEAN, 1.0f);
    if (!(middle > energy_min(t)) || !(self->energy_j > energy_min(t))) { return false; }
    self->lateness_s += pitch * sd_rsqrt_f32(2.0f * middle / t->inertia_interval_kgm2[k % t->positions]);
    return true;
}

static float magnitude(float x) { return (x < 0.0f) ? -x : x; }

static float root(float x) { return (x > 0.0f) ? x * sd_rsqrt_f32(x) : 0.0f; }

/* How late a tooth may be: jitter, and what a torque that nobody expects does over a mark. Once settled, both are known:
 * the innovation as met, and a firing that comes or fails; its peak is some 4 times its mean. */
static float limit_rad(const sd_kalman_t *self, const sd_kalman_tables_t *t, sd_between_t at, float scale) {
    const float mark = 3.0f * pitch_of(t);
    float jitter = t->reject_rad, torque = t->torque_base_nm;
    if (self->teeth >= t->settle_teeth) {
        jitter = 8.0f * blend(t->noise_rad, at) * blend(t->innovation, at) * root(self->noise_ratio);
        torque *= 0.05f;
        for (uint32_t j = 0; j < t->coefficients; ++j) {
            const float peak = 6.0f * magnitude(self->coefficient_nm[j]);
            torque = (peak > torque) ? peak : torque;
        }
    }
    return jitter + 0.5f * mark * mark * torque / scale;
}

static bool plausible(sd_kalman_t *self, const sd_kalman_tables_t *t, sd_between_t at, float scale) {
    self->test_ratio = magnitude(self->innovation_rad) / limit_rad(self, t, at, scale);
    if (!(self->test_ratio > 1.0f)) { self->rejected_in_row = 0; return true; }
    if (self->rejected < UINT16_MAX) { self->rejected++; }
    self->rejected_in_row++;
    return false;
}

/* Running mean square over some 2 cycles of what the tables expect to be 1. */
static void watch_noise(sd_kalman_t *self, const sd_kalman_tables_t *t, sd_between_t at) {
    const float expected = blend(t->noise_rad, at) * blend(t->innovation, at);
    const float ratio = self->innovation_rad / expected;
    self->noise_ratio += (ratio * ratio - self->noise_ratio) * (1.0f / 256.0f);
}

static void correct(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const uint32_t k = tooth->cycle_position;
    const float square = 2.0f * self->energy_j / t->inertia_tooth_kgm2[k % t->positions];
    const float slowness = sd_rsqrt_f32(square), speed = square * slowness;
    const float scale = t->inertia_mean_kgm2 * square;
    self->innovation_rad = -self->lateness_s * speed - tooth->late_rad;
    /* The normalised map is the same at every speed, so every table is stable at any. That of half the speed trusts the
     * state less, which is right while there is little to trust. */
    const bool settled = self->teeth >= t->settle_teeth;
    const sd_between_t at = find_speed(self, t, settled ? speed : 0.5f * speed);
    if (!plausible(self, t, at, scale)) { return; }
    if (settled) { watch_noise(self, t, at); }
    const float *low = gains_of(t, k, at.at), *high = gains_of(t, k, at.next);
    const float r = self->innovation_rad, push = r * scale;
    self->lateness_s += (low[0] + at.share * (high[0] - low[0])) * r * slowness;
    self->energy_j += (low[1] + at.share * (high[1] - low[1])) * push;
    for (uint32_t j = 0; j < t->coefficients; ++j) {
        self->coefficient_nm[j] += (low[2u + j] + at.share * (high[2u + j] - low[2u + j])) * push;
    }
}

/* Energy half a pitch before the tooth, from the tooth period. */
static void begin(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const float speed = pitch_of(t) * t->tick_hz / (float)tooth->period_ticks;
    const float energy = 0.5f * t->inertia_interval_kgm2[tooth->cycle_position % t->positions] * speed * speed;
    sd_kalman_restart(self);
    if (!(energy > energy_min(t))) { return; }
    self->energy_j = energy;
    self->running = 1;
}

static bool in_range(const sd_kalman_t *self, const sd_kalman_tables_t *t) {
    for (uint32_t j = 0; j < t->coefficients; ++j) {
        const float x = self->coefficient_nm[j];
        if (!((x > -t->torque_base_nm) && (x < t->torque_base_nm))) { return false; }
    }
    return (self->energy_j > energy_min(t)) && (self->energy_j < 1e9f) && (self->lateness_s > -1.0f) &&
           (self->lateness_s < 1.0f);
}

static void remember(sd_kalman_t *self, uint32_t i) {
    self->ring_nm[i][self->next[i]] = self->coefficient_nm[1u + i];
    self->next[i] = (uint8_t)((self->next[i] + 1u) % SD_KALMAN_MEAN);
    if (self->kept[i] < SD_KALMAN_MEAN) { self->kept[i]++; }
}

static void read_firing(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t i, float pattern_rad, sd_firing_t *firing) {
    const float square = 2.0f * self->energy_j / t->inertia_mean_kgm2, speed = root(square);
    const sd_between_t at = find_speed(self, t, speed);
    const float scale = t->inertia_mean_kgm2 * square, design = blend(t->noise_rad, at);
    /* Noise as met. A tooth's own error shows in the innovation too, but does not average out. */
    const float total = design * design * self->noise_ratio, fixed = pattern_rad * pattern_rad;
    const float fresh = (total > fixed) ? total - fixed : 0.0f;
    remember(self, i);
    const uint32_t count = self->kept[i];
    float sum = 0.0f;
    for (uint32_t j = 0; j < count; ++j) { sum += self->ring_nm[i][j]; }
    firing->index = (uint8_t)i;
    firing->torque_nm = self->coefficient_nm[1u + i];
    firing->mean_nm = sum / (float)count;
    const float single = blend(t->single_sd, at), mean = blend(t->mean_sd, at), stays = blend(t->pattern_sd, at);
    const float shape = t->shape_sd * firing->mean_nm;
    const float shrink = (float)SD_KALMAN_MEAN / (float)count; /* variance, taken as independent until it is full */
    const float load = (self->set > 0u) ? blend(t->load_sd_nm, at) : 0.0f;
    firing->noise_nm = scale * single * root(fresh);
    firing->sd_nm = root(firing->noise_nm * firing->noise_nm + scale * scale * stays * stays * fixed + shape * shape + load * load);
    firing->mean_sd_nm = root(scale * scale * (mean * mean * fresh * shrink + stays * stays * fixed) + shape * shape);
}

static bool pass(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k, float pattern_rad, sd_firing_t *firing) {
    for (uint32_t i = 0; i < t->firings; ++i) {
        if ((t->read_position[i] != k) || (self->teeth < t->positions)) { continue; } /* its whole pulse was seen */
        read_firing(self, t, i, pattern_rad, firing);
        return true;
    }
    return false;
}

static void take_intake(sd_kalman_t *self, float intake_bar) {
    self->intake_held = !((intake_bar >= 0.0f) && (intake_bar <= 10.0f));
    if (self->intake_held == 0u) { self->intake_bar = intake_bar; }
}

bool sd_kalman_step(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth, sd_firing_t *firing) {
    const uint32_t cycle = 2u * t->positions;
    if ((tooth->cycle_position >= cycle) || (tooth->advance < 1u) || (tooth->advance > cycle)) { return false; }
    take_intake(self, tooth->intake_bar);
    if (self->running == 0u) {
        if ((tooth->advance == 1u) && (tooth->trusted != 0u) && (tooth->period_ticks > 0u)) { begin(self, t, tooth); }
        return false;
    }
    bool complete = false, moving = true;
    for (uint32_t left = tooth->advance; (left-- > 0u) && moving;) {
        const uint32_t k = (tooth->cycle_position + cycle - left) % cycle;
        moving = predict(self, t, k);
        complete |= pass(self, t, k, tooth->pattern_rad, firing);
    }
    self->lateness_s -= (float)tooth->period_ticks / t->tick_hz;
    if (moving && (tooth->trusted != 0u)) { correct(self, t, tooth); }
    self->torque_nm = torque_by(self, t, tooth->cycle_position, POINT, 1.0f);
    if (!moving || !in_range(self, t) || (self->rejected_in_row > REJECTED_IN_ROW_MAX)) {
        sd_kalman_restart(self);
        return false;
    }
    if (self->teeth < UINT16_MAX) { self->teeth++; }
    return complete;
}

void sd_kalman_restart(sd_kalman_t *self) {
    const uint16_t rejected = self->rejected;
    const float intake_bar = self->intake_bar;
    const uint8_t held = self->intake_held, set = self->set;
    memset(self, 0, sizeof *self);
    self->noise_ratio = 1.0f;
    self->rejected = rejected;
    self->intake_bar = intake_bar;
    self->intake_held = held;
    self->set = set;
}

sd_status_t sd_kalman_status(const sd_kalman_t *self, const sd_kalman_tables_t *t) {
    sd_status_t status = { .rejected = self->rejected, .innovation = self->innovation_rad, .test_ratio = self->test_ratio };
    if (self->running == 0u) {
        status.health = SD_INVALID;
        status.why = SD_WHY_CONVERGING;
        return status;
    }
    if (self->teeth < t->settle_teeth) { status.why |= SD_WHY_CONVERGING; }
    if ((self->rejected_in_row > 0u) || (self->intake_held != 0u)) { status.why |= SD_WHY_REJECTED; }
    if (status.why != 0u) { status.health = SD_DEGRADED; }
    return status;
}

/* ---- init -------------------------------------------------------------------------------------------------------- */

static bool all_within(const float *values, uint32_t count, float from, float to) {
    for (uint32_t i = 0; i < count; ++i) {
        if (!((values[i] >= from) && (values[i] <= to))) { return false; } /* NaN is out of range */
    }
    return true;
}

static bool sizes_ok(const sd_kalman_tables_t *t) {
    if ((t->positions < 12u) || (t->positions > SD_KALMAN_POSITIONS_MAX) || (t->positions % 2u != 0u)) { return false; }
    if ((t->coefficients < 1u) || (t->coefficients > SD_KALMAN_COEFFICIENTS_MAX)) { return false; }
    if ((t->speeds < 1u) || (t->speeds > SD_KALMAN_SPEEDS_MAX) || (t->sets < 1u) || (t->sets > SD_KALMAN_SETS_MAX)) { return false; }
    if (sd_kalman_pool_used(t) > SD_KALMAN_POOL) { return false; }
    if ((t->firings > SD_KALMAN_FIRINGS_MAX) || (t->firings >= t->coefficients)) { return false; }
    for (uint32_t i = 0; i < t->firings; ++i) {
        if (t->read_position[i] >= 2u * t->positions) { return false; }
    }
    for (uint32_t i = 1; i < t->speeds; ++i) {
        if (!(t->speed_radps[i] > t->speed_radps[i - 1u])) { return false; }
    }
    return true;
}

static bool tables_ok(const sd_kalman_tables_t *t) {
    if (!sizes_ok(t)) { return false; }
    const uint32_t n = t->positions, gains = (uint32_t)t->sets * t->speeds;
    bool ok = all_within(&t->tick_hz, 1u, 1e5f, 2e8f) && all_within(&t->torque_base_nm, 1u, 1e-3f, 2e4f) &&
              all_within(&t->shape_sd, 1u, 0.0f, 1.0f) && all_within(&t->reject_rad, 1u, 1e-6f, 1.0f) && all_within(&t->inertia_mean_kgm2, 1u, 1e-6f, 10.0f) &&
              all_within(t->inertia_tooth_kgm2, n, 1e-6f, 10.0f) && all_within(t->inertia_interval_kgm2, n, 1e-6f, 10.0f) &&
              all_within(t->speed_radps, t->speeds, 1.0f, 2000.0f) && all_within(t->noise_rad, gains, 1e-7f, 1.0f) &&
              all_within(t->innovation, gains, 1.0f, 1e3f) && all_within(t->single_sd, gains, 0.0f, 1e6f) &&
              all_within(t->mean_sd, gains, 0.0f, 1e6f) && all_within(t->pattern_sd, gains, 0.0f, 1e6f) &&
              all_within(t->load_sd_nm, gains, 0.0f, 1e6f);
    for (uint32_t which = 0; ok && (which < 3u); ++which) {
        ok = all_within(t->known[which], 2u * n, -1e5f, 1e5f) && all_within(t->known_per_bar[which], 2u * n, -1e5f, 1e5f);
    }
    return ok && all_within(t->pool, sd_kalman_pool_used(t), -1e6f, 1e6f);
}

sd_result_t sd_kalman_init(sd_kalman_t *self, const sd_kalman_tables_t *tables) {
    if (!tables_ok(tables)) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->intake_bar = 1.0f;
    sd_kalman_restart(self);
    return SD_OK;
}
