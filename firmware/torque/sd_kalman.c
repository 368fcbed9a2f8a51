/* SPDX-License-Identifier: MIT */
#include "sd_kalman.h"

#include <string.h>

#define TWO_PI 6.2831853f
#define TWIST_MAX_RAD 2.0f /* no flywheel's spring goes so far */

static const float INVERSE[6] = { 1.0f, 0.5f, 1.0f / 3.0f, 0.25f, 0.2f, 1.0f / 6.0f };

_Static_assert(sizeof(sd_kalman_t) == 584, "without pointers, the same size on every target");

enum { REJECTED_IN_ROW_MAX = 12, /* teeth left out in a row after which the estimate itself must be wrong */
       SPEED_MIN_RADPS = 5 };

/* Where a speed lies among the gain tables of the filter's set: between `at` and the next one, `share` of the way. */
typedef struct sd_between {
    uint32_t at, next;
    float    share;
} sd_between_t;

static sd_between_t find_speed(const sd_kalman_t *self, const sd_kalman_tables_t *t, float speed) {
    sd_between_t b = { 0, 0, 0.0f };
    speed *= self->tuning.gain_speed;
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

/* Where the parts of a row begin (sd_kalman.h). */
static uint32_t motored_from(const sd_kalman_tables_t *t) { return 3u * (t->coefficients - 1u); }

static uint32_t shapes_from(const sd_kalman_tables_t *t) { return motored_from(t) + 3u * t->cylinders; }

static uint32_t modes_from(const sd_kalman_tables_t *t) { return shapes_from(t) + 3u * t->shapes * t->firings; }

static uint32_t gains_from(const sd_kalman_tables_t *t) { return modes_from(t) + 2u * t->modes; }

static uint32_t gains_size(const sd_kalman_tables_t *t) { return t->coefficients + 2u + t->shapes + 2u * t->modes; }

static uint32_t row_size(const sd_kalman_tables_t *t) {
    return gains_from(t) + (uint32_t)t->sets * t->speeds * gains_size(t);
}

uint32_t sd_kalman_pool_used(const sd_kalman_tables_t *tables) { return 2u * tables->positions * row_size(tables); }

static const float *row_of(const sd_kalman_tables_t *t, uint32_t k) { return &t->pool[k * row_size(t)]; }

static const float *gains_of(const sd_kalman_tables_t *t, uint32_t k, uint32_t speed) {
    return row_of(t, k) + gains_from(t) + speed * gains_size(t);
}

enum { MEAN, MOMENT, POINT };

/* T by one of the three tables; `whole` is what a constant torque has there. */
static float torque_by(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k, uint32_t which, float whole) {
    const uint32_t count = t->coefficients - 1u;
    const float *f = row_of(t, k) + which * count, *g = row_of(t, k) + motored_from(t) + which * t->cylinders;
    float sum = t->known[which][k] + whole * self->coefficient_nm[0];
    for (uint32_t j = 0; j < count; ++j) { sum += f[j] * self->coefficient_nm[1u + j]; }
    for (uint32_t i = 0; i < t->cylinders; ++i) { sum += g[i] * self->charge_bar[i]; }
    if (t->shapes == 0u) { return sum; }
    const float *bend = row_of(t, k) + shapes_from(t) + which * t->firings;
    for (uint32_t j = 0; j < t->firings; ++j) { sum += self->shape * bend[j] * self->coefficient_nm[1u + j]; }
    return sum;
}

/* The twist that the mean torques of an interval would hold, of mode m; firing j is cylinder j where there are modes. */
static float held_twist(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k, uint32_t m, float square) {
    const float *f = row_of(t, k), *g = f + motored_from(t), *bend = f + shapes_from(t), *known = f + modes_from(t) + 2u * m;
    const sd_kalman_mode_t *mode = &t->mode[m];
    float sum = known[0] + known[1] * square + mode->constant_radpnm * self->coefficient_nm[0];
    for (uint32_t i = 0; i < t->cylinders; ++i) {
        const float pulse = f[i] + ((t->shapes != 0u) ? self->shape * bend[i] : 0.0f);
        sum += mode->cylinder_radpnm[i] * (pulse * self->coefficient_nm[1u + i] + g[i] * self->charge_bar[i]);
    }
    return sum;
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

static float frequency_radps(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t m) {
    return self->tuning.frequency * t->mode[m].frequency_radps;
}

static void swing(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k, float dt, float square) {
    for (uint32_t m = 0; m < t->modes; ++m) {
        const float held = self->tuning.compliance * held_twist(self, t, k, m, square), away = self->twist_rad[m] - held, v = self->swing_rad[m];
        const float z = t->mode[m].damping;
        float a, b;
        exponential(frequency_radps(self, t, m) * dt, z, &a, &b);
        self->twist_rad[m] = held + a * away + b * v;
        self->swing_rad[m] = a * v - b * (away + 2.0f * z * v);
    }
}

float sd_kalman_torque(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k) {
    return torque_by(self, t, k, MEAN, 1.0f);
}

bool sd_kalman_has_tooth(const sd_kalman_tables_t *t, uint32_t k) { return gains_of(t, k, 0)[0] != 0.0f; }

static float pitch_of(const sd_kalman_tables_t *t) { return TWO_PI / (float)t->positions; }

static float energy_min(const sd_kalman_tables_t *t) {
    return 0.5f * t->inertia_mean_kgm2 * (float)(SPEED_MIN_RADPS * SPEED_MIN_RADPS);
}

static void close_valves(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k) {
    for (uint32_t i = 0; i < t->cylinders; ++i) {
        if (t->close_position[i] == k) { self->charge_bar[i] = self->intake_bar; }
    }
}

/* Over the interval that ends at cycle position k. False when the crank would stand still in it. */
static bool predict(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k) {
    const float pitch = pitch_of(t);
    const float middle = self->energy_j + pitch * torque_by(self, t, k, MOMENT, 0.5f);
    self->energy_j += pitch * torque_by(self, t, k, MEAN, 1.0f);
    if (!(middle > energy_min(t)) || !(self->energy_j > energy_min(t))) { return false; }
    const float square = 2.0f * middle / t->inertia_interval_kgm2[k % t->positions], dt = pitch * sd_rsqrt_f32(square);
    self->lateness_s += dt;
    swing(self, t, k, dt, square);
    return true;
}

static float magnitude(float x) { return (x < 0.0f) ? -x : x; }

static float root(float x) { return (x > 0.0f) ? x * sd_rsqrt_f32(x) : 0.0f; }

/* How late a tooth may be: jitter, and what a torque that nobody expects does over a mark. Once settled, both are known:
 * the innovation as met, and a firing that comes or fails; its peak is some 4 times its mean. */
static float limit_rad(const sd_kalman_t *self, const sd_kalman_tables_t *t, sd_between_t at, float scale) {
    const float mark = 3.0f * pitch_of(t);
    float jitter = self->choice.reject_rad, torque = self->choice.torque_base_nm;
    if (self->teeth >= self->choice.settle_teeth) {
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

/* Of the rigid crank at tooth k. */
static float square_speed(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k) {
    return 2.0f * self->energy_j / t->inertia_tooth_kgm2[k % t->positions];
}

/* A wheel twisted ahead by q and turning faster by q' comes q / (w + q') early. */
static float late_rad(const sd_kalman_t *self, const sd_kalman_tables_t *t, float speed, float slowness) {
    float twist = 0.0f, rate = 0.0f;
    for (uint32_t m = 0; m < t->modes; ++m) {
        twist += self->twist_rad[m];
        rate += self->swing_rad[m] * frequency_radps(self, t, m);
    }
    return twist * (1.0f - rate * slowness) - self->lateness_s * speed;
}

float sd_kalman_late(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t cycle_position) {
    const float square = square_speed(self, t, cycle_position), slowness = sd_rsqrt_f32(square);
    return late_rad(self, t, square * slowness, slowness);
}

static float mean_firing(const sd_kalman_t *self, const sd_kalman_tables_t *t) {
    float sum = 0.0f;
    for (uint32_t j = 0; j < t->firings; ++j) { sum += self->coefficient_nm[1u + j]; }
    return sum / (float)t->firings;
}

/* The gain is that of shape times the mean torque. */
static void bend_pulses(sd_kalman_t *self, const sd_kalman_tables_t *t, float change_nm) {
    const float mean = mean_firing(self, t);
    if (!(mean > t->shape_min_nm)) { return; }
    const float shape = self->shape + change_nm / mean;
    self->shape = (shape < SD_KALMAN_SHAPE_MIN) ? SD_KALMAN_SHAPE_MIN : (shape > SD_KALMAN_SHAPE_MAX) ? SD_KALMAN_SHAPE_MAX : shape;
}

static void correct(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const uint32_t k = tooth->cycle_position;
    const float square = square_speed(self, t, k), slowness = sd_rsqrt_f32(square), speed = square * slowness;
    const float scale = t->inertia_mean_kgm2 * square;
    self->innovation_rad = late_rad(self, t, speed, slowness) - tooth->late_rad;
    /* Without modes the normalised map is the same at every speed, so every table is stable at any. That of half the speed
     * trusts the state less, which is right while there is little to trust. */
    const bool settled = self->teeth >= self->choice.settle_teeth;
    const sd_between_t at = find_speed(self, t, (settled || (t->modes > 0u)) ? speed : 0.5f * speed);
    if (!plausible(self, t, at, scale)) { return; }
    if (settled) { watch_noise(self, t, at); }
    const float *low = gains_of(t, k, at.at), *high = gains_of(t, k, at.next);
    const float r = self->innovation_rad, push = r * scale;
    self->lateness_s += (low[0] + at.share * (high[0] - low[0])) * r * slowness;
    self->energy_j += (low[1] + at.share * (high[1] - low[1])) * push;
    for (uint32_t j = 0; j < t->coefficients; ++j) {
        self->coefficient_nm[j] += (low[2u + j] + at.share * (high[2u + j] - low[2u + j])) * push;
    }
    low += 2u + t->coefficients, high += 2u + t->coefficients;
    if (t->shapes != 0u) {
        if (settled) { bend_pulses(self, t, (low[0] + at.share * (high[0] - low[0])) * push); }
        low++, high++;
    }
    for (uint32_t m = 0; m < t->modes; ++m, low += 2, high += 2) {
        self->twist_rad[m] += (low[0] + at.share * (high[0] - low[0])) * r;
        self->swing_rad[m] += (low[1] + at.share * (high[1] - low[1])) * r;
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
        if (!((x > -self->choice.torque_base_nm) && (x < self->choice.torque_base_nm))) { return false; }
    }
    for (uint32_t m = 0; m < t->modes; ++m) {
        const float q = self->twist_rad[m], v = self->swing_rad[m];
        if (!((q > -TWIST_MAX_RAD) && (q < TWIST_MAX_RAD) && (v > -TWIST_MAX_RAD) && (v < TWIST_MAX_RAD))) { return false; }
    }
    return (self->energy_j > energy_min(t)) && (self->energy_j < 1e9f) && (self->lateness_s > -1.0f) &&
           (self->lateness_s < 1.0f);
}

static void remember(sd_kalman_t *self, uint32_t i, float torque_nm) {
    self->ring_nm[i][self->next[i]] = torque_nm;
    self->next[i] = (uint8_t)((self->next[i] + 1u) % SD_KALMAN_MEAN);
    if (self->kept[i] < SD_KALMAN_MEAN) { self->kept[i]++; }
}

/* Variance of a firing less the mean of all, from what is not known of the engine. */
static float model_variance(const sd_kalman_t *self, const sd_kalman_tables_t *t, sd_between_t at, uint32_t i) {
    const float mean = mean_firing(self, t);
    float spread = 0.0f;
    for (uint32_t j = 0; j < t->firings; ++j) {
        const float apart = self->coefficient_nm[1u + j] - mean;
        spread += apart * apart / (float)t->firings;
    }
    const float of_mean = blend(t->mean_share, at), of_spread = blend(t->spread_share, at);
    const float of_charge = blend((self->zero_nm_per_bar[i] != 0.0f) ? t->learned_nm_per_bar : t->charge_nm_per_bar, at) * self->charge_bar[i];
    return of_mean * of_mean * mean * mean + of_spread * of_spread * spread + of_charge * of_charge;
}

static void read_firing(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t i, float pattern_rad, sd_firing_t *firing) {
    const float square = 2.0f * self->energy_j / t->inertia_mean_kgm2, speed = root(square);
    const sd_between_t at = find_speed(self, t, speed);
    const float scale = t->inertia_mean_kgm2 * square, design = blend(t->noise_rad, at);
    /* Noise as met. A tooth's own error shows in the innovation too, but does not average out. */
    const float total = design * design * self->noise_ratio, fixed = pattern_rad * pattern_rad;
    const float fresh = (total > fixed) ? total - fixed : 0.0f;
    firing->raw_nm = self->coefficient_nm[1u + i];
    firing->torque_nm = firing->raw_nm - self->zero_nm_per_bar[i] * self->charge_bar[i];
    remember(self, i, firing->torque_nm);
    const uint32_t count = self->kept[i];
    float sum = 0.0f;
    for (uint32_t j = 0; j < count; ++j) { sum += self->ring_nm[i][j]; }
    firing->index = (uint8_t)i;
    firing->mean_nm = sum / (float)count;
    const float single = blend(t->single_sd, at), mean = blend(t->mean_sd, at), stays = blend(t->pattern_sd, at);
    const float model = model_variance(self, t, at, i);
    const float shrink = (float)SD_KALMAN_MEAN / (float)count; /* variance, taken as independent until it is full */
    const float load = (self->set > 0u) ? blend(t->load_sd_nm, at) : 0.0f;
    firing->noise_nm = scale * single * ((fresh > design * design) ? root(fresh) : design);
    firing->sd_nm = root(scale * scale * single * single * fresh + scale * scale * stays * stays * fixed + model + load * load);
    firing->mean_sd_nm = root(scale * scale * (mean * mean * fresh * shrink + stays * stays * fixed) + model);
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

void sd_kalman_set_intake(sd_kalman_t *self, float intake_bar) {
    self->intake_bar = intake_bar;
    for (uint32_t i = 0; i < SD_KALMAN_FIRINGS_MAX; ++i) { self->charge_bar[i] = intake_bar; }
}

/* What a dual-mass flywheel takes from the crank beyond the constant torque. */
static float through_spring(const sd_kalman_t *self, const sd_kalman_tables_t *t) {
    const float r = self->tuning.frequency;
    float torque = 0.0f;
    for (uint32_t m = 0; m < t->modes; ++m) {
        torque += r * t->mode[m].spring_nmprad * self->twist_rad[m] + t->mode[m].damper_nmprad * self->swing_rad[m];
    }
    return r * torque;
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
        close_valves(self, t, k);
        complete |= pass(self, t, k, tooth->pattern_rad, firing);
    }
    self->lateness_s -= (float)tooth->period_ticks / t->tick_hz;
    if (moving && (tooth->trusted != 0u)) { correct(self, t, tooth); }
    self->torque_nm = torque_by(self, t, tooth->cycle_position, POINT, 1.0f) - through_spring(self, t);
    if (!moving || !in_range(self, t) || (self->rejected_in_row > REJECTED_IN_ROW_MAX)) {
        sd_kalman_restart(self);
        return false;
    }
    if (self->teeth < UINT16_MAX) { self->teeth++; }
    return complete;
}

void sd_kalman_restart(sd_kalman_t *self) {
    const uint16_t rejected = self->rejected;
    const float intake_bar = self->intake_bar, shape = self->shape;
    const uint8_t held = self->intake_held, set = self->set;
    const sd_kalman_tuning_t tuning = self->tuning;
    const sd_kalman_choice_t choice = self->choice;
    float zero[SD_KALMAN_FIRINGS_MAX];
    memcpy(zero, self->zero_nm_per_bar, sizeof zero);
    memset(self, 0, sizeof *self);
    memcpy(self->zero_nm_per_bar, zero, sizeof zero);
    self->tuning = tuning;
    self->choice = choice;
    self->noise_ratio = 1.0f;
    self->shape = shape;
    self->rejected = rejected;
    sd_kalman_set_intake(self, intake_bar);
    self->intake_held = held;
    self->set = set;
}

sd_status_t sd_kalman_status(const sd_kalman_t *self) {
    sd_status_t status = { .rejected = self->rejected, .innovation = self->innovation_rad, .test_ratio = self->test_ratio };
    if (self->running == 0u) {
        status.health = SD_INVALID;
        status.why = SD_WHY_CONVERGING;
        return status;
    }
    if (self->teeth < self->choice.settle_teeth) { status.why |= SD_WHY_CONVERGING; }
    if ((self->rejected_in_row > 0u) || (self->intake_held != 0u)) { status.why |= SD_WHY_REJECTED; }
    if (status.why != 0u) { status.health = SD_DEGRADED; }
    return status;
}

sd_result_t sd_kalman_init(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_choice_t *choice) {
    if (!sd_kalman_tables_ok(tables) || !sd_kalman_choice_ok(choice)) { return SD_ERR_CONFIG; }
    const sd_kalman_choice_t chosen = *choice; /* it may stand in *self */
    memset(self, 0, sizeof *self);
    self->choice = chosen;
    self->tuning = (sd_kalman_tuning_t){ 1.0f, 1.0f, 1.0f };
    sd_kalman_set_intake(self, 1.0f);
    sd_kalman_restart(self);
    return SD_OK;
}
