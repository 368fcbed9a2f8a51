/* SPDX-License-Identifier: MIT */
#include "sd_afr_joint.h"

#include <string.h>

#include "sd_math.h"

enum { REJECTED_IN_ROW_MAX = 60, /* positions left out in a row after which the estimate must be wrong */
       JUMP_HOLD = 120 };        /* positions, about a cycle, until the next jump may be seen */

#define SHORT_STEP 3e-4f   /* s: positions so short that the core has little time */
#define LONG_LAGS  150.0f  /* positions */
#define MEAN_PACE  0.0598f /* a position: the mean of innovations reaches back 16 positions */
#define JUMP_SQUARE 25.0f  /* a jump is five standard deviations of such a mean */
#define VARIANCE_LEAST 1e-12f
#define KEPT_LEAST     0.05f /* of x in a position: so little that it does not matter, and a group of it is still above 0 */

sd_result_t sd_afr_joint_check(const sd_afr_joint_config_t *c) {
    const bool ok = (c->cylinders >= 1u) && (c->cylinders <= SD_AFR_CYLINDERS_MAX) && (c->cycle_positions >= 24u) &&
                    (c->cycle_positions <= SD_AFR_POSITIONS_MAX) && sd_within(c->tau1_s, 1e-4f, 1.0f) &&
                    sd_within(c->tau2_s, 1e-4f, 1.0f) && sd_within(c->noise_per_rthz, 1e-7f, 0.1f) &&
                    sd_within(c->drift, 1e-6f, 1.0f) && sd_within(c->start_sd, 1e-3f, 1.0f) && sd_within(c->reject, 3.0f, 1e3f);
    return ok ? SD_OK : SD_ERR_CONFIG;
}

sd_result_t sd_afr_joint_init(sd_afr_joint_t *self, const sd_afr_joint_config_t *c) {
    if (sd_afr_joint_check(c) != SD_OK) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->config = *c;
    sd_afr_joint_set(self, 1e-3f, c->drift, 0.0f);
    return SD_OK;
}

/* What moves by so much in a position moves by this in a group. */
static float group_of(const sd_afr_joint_t *self, float move) {
    float keep = 1.0f;
    for (uint32_t k = 0; k < self->group; ++k) { keep *= 1.0f - move; }
    return 1.0f - keep;
}

/* At high speed twice as many positions, while they are short beside the sensor's lags and leave two groups from one firing to the
   next. */
static bool may_be_long(const sd_afr_joint_config_t *c, float step_s) {
    return (step_s < SHORT_STEP) && (c->tau1_s + c->tau2_s > LONG_LAGS * step_s) &&
           (4u * SD_AFR_GROUP * c->cylinders <= c->cycle_positions);
}

void sd_afr_joint_set(sd_afr_joint_t *self, float step_s, float drift, float jump) {
    if (!(step_s > 0.0f) || !(step_s <= 0.1f) || !sd_within(drift, 1e-6f, 1.0f) || !sd_within(jump, 0.0f, 1.0f)) { return; }
    self->move2 = sd_lag_move(step_s / self->config.tau2_s);
    self->move1 = sd_lag_move(step_s / self->config.tau1_s);
    self->group = may_be_long(&self->config, step_s) ? 2u * SD_AFR_GROUP : SD_AFR_GROUP;
    self->group2 = group_of(self, self->move2);
    self->group1 = group_of(self, self->move1);
    self->pace = group_of(self, MEAN_PACE);
    self->mean_max = JUMP_SQUARE * self->pace / (2.0f - self->pace); /* that mean's variance is pace/(2 - pace) of an innovation's */
    self->noise_var = self->config.noise_per_rthz * self->config.noise_per_rthz / (2.0f * step_s);
    self->drift_var = drift * drift;
    self->jump_var = jump * jump;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { /* rounding must not make it negative */
        if (!(self->p.a[i][i] > VARIANCE_LEAST)) { self->p.a[i][i] = VARIANCE_LEAST; }
    }
}

void sd_afr_joint_restart(sd_afr_joint_t *self) { self->running = 0; }

/* Every state varies by so much more, for itself. */
static void let_go(sd_afr_joint_t *self, float variance) {
    sd_afr_covariance_t *p = &self->p;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { p->a[i][i] += variance; }
    p->x_x += variance;
    p->s2_s2 += variance;
    p->s1_s1 += variance;
}

static void begin(sd_afr_joint_t *self, float measured) {
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { self->air_fraction[i] = measured; }
    self->x = self->lag2 = self->lag1 = measured;
    memset(&self->p, 0, sizeof self->p);
    let_go(self, self->config.start_sd * self->config.start_sd);
    memset(self->let_in, 0, sizeof self->let_in);
    self->error = self->mean_innovation = 0.0f;
    self->keep = 1.0f;
    self->positions = self->samples = self->flowing = 0;
    self->rejected_in_row = 0;
    self->hold = JUMP_HOLD;
    self->running = 1;
}

/* A row over the cylinders becomes keep times itself plus share times another. By four, which costs half of one by one. */
static inline void blend(float *row, const float *other, float keep, float share, uint32_t n) {
    for (uint32_t i = 0; i < n; i += 4u) {
        row[i] = keep * row[i] + share * other[i];
        row[i + 1u] = keep * row[i + 1u] + share * other[i + 1u];
        row[i + 2u] = keep * row[i + 2u] + share * other[i + 2u];
        row[i + 3u] = keep * row[i + 3u] + share * other[i + 3u];
    }
}

/* x becomes (1 - share) x + share a_i; its covariances follow. */
static void let_in(sd_afr_covariance_t *p, uint32_t i, float share, uint32_t n) {
    const float keep = 1.0f - share;
    p->x_x = keep * (keep * p->x_x + 2.0f * share * p->x_a[i]) + share * share * p->a[i][i];
    p->s2_x = keep * p->s2_x + share * p->s2_a[i];
    p->s1_x = keep * p->s1_x + share * p->s1_a[i];
    blend(p->x_a, p->a[i], keep, share, n);
}

/* s2 follows x and s1 follows s2. */
static void lag(sd_afr_joint_t *self, uint32_t n) {
    sd_afr_covariance_t *p = &self->p;
    const float m2 = self->group2, k2 = 1.0f - m2, m1 = self->group1, k1 = 1.0f - m1;
    p->s2_s2 = k2 * (k2 * p->s2_s2 + 2.0f * m2 * p->s2_x) + m2 * m2 * p->x_x;
    p->s2_x = k2 * p->s2_x + m2 * p->x_x;
    p->s1_s2 = k2 * p->s1_s2 + m2 * p->s1_x;
    blend(p->s2_a, p->x_a, k2, m2, n);
    p->s1_s1 = k1 * (k1 * p->s1_s1 + 2.0f * m1 * p->s1_s2) + m1 * m1 * p->s2_s2;
    p->s1_s2 = k1 * p->s1_s2 + m1 * p->s2_s2;
    p->s1_x = k1 * p->s1_x + m1 * p->s2_x;
    blend(p->s1_a, p->s2_a, k1, m1, n);
}

/* The covariance moves on by a group. The lags first, by the x before: s2 is late by that, s1, which follows the new s2, early,
   and their mean over the group is what the samples' mean error is of. */
static void predict(sd_afr_joint_t *self) {
    const uint32_t n = self->config.cylinders;
    uint32_t flowing = 0;
    float sum = 1.0f;
    lag(self, n);
    for (uint32_t i = 0; i < n; ++i) {
        const float added = self->let_in[i];
        if (!(added > 0.0f)) { continue; }
        flowing |= 1u << i;
        if ((((uint32_t)self->flowing >> i) & 1u) == 0u) { self->p.a[i][i] += self->drift_var; } /* its exhaust begins */
        sum += added;
        let_in(&self->p, i, added / sum, n);
        self->let_in[i] = 0.0f;
    }
    self->flowing = (uint8_t)flowing;
    self->keep = 1.0f;
}

static void correct(sd_afr_joint_t *self, const float *k, float error) {
    const uint32_t n = self->config.cylinders;
    self->x += k[0] * error;
    for (uint32_t i = 0; i < n; ++i) { self->air_fraction[i] += k[1u + i] * error; }
    self->lag2 += k[n + 1u] * error;
    self->lag1 += k[n + 2u] * error;
}

/* Innovations that keep to one side: something has moved more than drift allows. Which cylinder is for the samples to say:
   all states are let go alike, the sensor's too, since they have followed the wrong gas until now. */
static void watch(sd_afr_joint_t *self, float error, float inverse) {
    self->mean_innovation += self->pace * (error - self->mean_innovation);
    self->hold = (self->hold > self->positions) ? (uint16_t)(self->hold - self->positions) : 0u;
    const float square = self->mean_innovation * self->mean_innovation * inverse;
    if ((square < self->mean_max) || (self->hold > 0u) || !(self->jump_var > 0.0f)) { return; }
    let_go(self, self->jump_var);
    self->mean_innovation = 0.0f;
    self->hold = JUMP_HOLD;
    self->jumps++;
}

/* P -= K h' P with h the last state and K = P h inverse: a row of the cylinders, for four of them at a time. */
static inline void shrink(float *row, const float *s1_a, float gain, uint32_t n) {
    for (uint32_t i = 0; i < n; i += 4u) {
        row[i] -= gain * s1_a[i];
        row[i + 1u] -= gain * s1_a[i + 1u];
        row[i + 2u] -= gain * s1_a[i + 2u];
        row[i + 3u] -= gain * s1_a[i + 3u];
    }
}

/* State and covariance, by the mean error of the samples; inverse of its variance. */
static void take_in(sd_afr_joint_t *self, float error, float inverse) {
    sd_afr_covariance_t *p = &self->p;
    const uint32_t n = self->config.cylinders;
    const float s1_x = p->s1_x, s1_s2 = p->s1_s2, s1_s1 = p->s1_s1;
    const float of_x = s1_x * inverse, of_s2 = s1_s2 * inverse, of_s1 = s1_s1 * inverse;
    for (uint32_t i = 0; i < n; ++i) {
        const float of_a = p->s1_a[i] * inverse;
        self->air_fraction[i] += of_a * error;
        shrink(p->a[i], p->s1_a, of_a, n);
    }
    shrink(p->x_a, p->s1_a, of_x, n);
    shrink(p->s2_a, p->s1_a, of_s2, n);
    shrink(p->s1_a, p->s1_a, of_s1, n);
    self->x += of_x * error;
    self->lag2 += of_s2 * error;
    self->lag1 += of_s1 * error;
    p->x_x -= of_x * s1_x;
    p->s2_x -= of_s2 * s1_x;
    p->s2_s2 -= of_s2 * s1_s2;
    p->s1_x -= of_s1 * s1_x;
    p->s1_s2 -= of_s1 * s1_s2;
    p->s1_s1 -= of_s1 * s1_s1;
}

/* What the samples of a group say. */
static void update(sd_afr_joint_t *self) {
    const float part = 1.0f / (float)self->samples, error = part * self->error;
    const float inverse = 1.0f / (((self->p.s1_s1 > 0.0f) ? self->p.s1_s1 : 0.0f) + part * self->noise_var);
    self->innovation = error;
    self->test_ratio = error * error * inverse / (self->config.reject * self->config.reject);
    if (self->test_ratio > 1.0f) {
        if (self->rejected < UINT16_MAX) { self->rejected++; }
        self->rejected_in_row = (uint16_t)(self->rejected_in_row + self->positions);
        if (self->rejected_in_row > REJECTED_IN_ROW_MAX) { self->running = 0; }
        return;
    }
    self->rejected_in_row = 0;
    take_in(self, error, inverse);
    watch(self, error, inverse);
}

static void end_group(sd_afr_joint_t *self) {
    predict(self);
    if (self->samples > 0u) { update(self); }
    self->error = 0.0f;
    self->positions = self->samples = 0;
    if (!((self->x > -4.0f) && (self->x < 4.0f))) { self->running = 0; } /* or NaN: begins anew */
}

/* x with what comes in at a position, which let_in counts by what is left of x from before the group. */
static inline float mix(sd_afr_joint_t *self, const sd_afr_inflow_t *in) {
    const uint32_t count = in->count;
    const float keep = self->keep * ((in->kept > KEPT_LEAST) ? in->kept : KEPT_LEAST), per_kept = in->per_mass / keep;
    float sum = 0.0f;
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t i = in->cylinder[k];
        sum += in->added[k] * self->air_fraction[i];
        self->let_in[i] += in->added[k] * per_kept;
    }
    self->keep = keep;
    return in->kept * self->x + in->per_mass * sum;
}

void sd_afr_joint_step(sd_afr_joint_t *self, const sd_afr_inflow_t *in, float measured, const float *gains) {
    const bool seen = (measured > -2.0f) && (measured < 2.0f);
    if (self->running == 0u) {
        if (seen) { begin(self, measured); }
        return;
    }
    const float x = (in->count > 0u) ? mix(self, in) : self->x;
    const float lag2 = self->lag2 + self->move2 * (x - self->lag2), lag1 = self->lag1 + self->move1 * (lag2 - self->lag1);
    self->x = x;
    self->lag2 = lag2;
    self->lag1 = lag1;
    if (gains != 0) {
        if (seen) { correct(self, gains, measured - lag1); }
        return;
    }
    if (seen) {
        self->error += measured - lag1;
        self->samples++;
    }
    self->positions++;
    if (self->positions >= self->group) { end_group(self); }
}

void sd_afr_joint_move(sd_afr_joint_t *self, uint32_t cylinder, float lambda_change) {
    if ((self->running == 0u) || (cylinder >= self->config.cylinders) || !sd_within(lambda_change, -1.0f, 1.0f)) { return; }
    self->air_fraction[cylinder] -= lambda_change;
}

float sd_afr_joint_lambda(const sd_afr_joint_t *self, uint32_t cylinder) {
    if ((self->running == 0u) || (cylinder >= self->config.cylinders)) { return 0.0f; }
    return 1.0f - self->air_fraction[cylinder];
}

/* Of a_i - mean: P_ii - 2 (sum of row i)/n + (sum of all)/n^2. */
void sd_afr_joint_deviation_variances(const sd_afr_joint_t *self, float *variance) {
    const uint32_t n = self->config.cylinders;
    const float part = 1.0f / (float)n;
    float all = 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        const float *row = self->p.a[i];
        float sum = 0.0f;
        for (uint32_t j = 0; j < n; ++j) { sum += row[j]; }
        all += sum;
        variance[i] = row[i] - 2.0f * part * sum;
    }
    for (uint32_t i = 0; i < n; ++i) { variance[i] += part * part * all; }
}

float sd_afr_joint_covariance(const sd_afr_joint_t *self, uint32_t row, uint32_t column) {
    const sd_afr_covariance_t *p = &self->p;
    const uint32_t n = self->config.cylinders, high = (row > column) ? row : column, low = (row > column) ? column : row;
    if (high >= n + 3u) { return 0.0f; }
    if (high == 0u) { return p->x_x; }
    if (high <= n) { return (low == 0u) ? p->x_a[high - 1u] : p->a[high - 1u][low - 1u]; }
    const bool of_s1 = high == n + 2u;
    if (low == 0u) { return of_s1 ? p->s1_x : p->s2_x; }
    if (low <= n) { return of_s1 ? p->s1_a[low - 1u] : p->s2_a[low - 1u]; }
    return !of_s1 ? p->s2_s2 : (low == high) ? p->s1_s1 : p->s1_s2;
}

/* In place, by Gauss and Jordan without pivots: it is positive definite. */
static void invert(float m[][SD_AFR_CYLINDERS_MAX], uint32_t n) {
    for (uint32_t k = 0; k < n; ++k) {
        const float inverse = 1.0f / m[k][k];
        m[k][k] = 1.0f;
        for (uint32_t j = 0; j < n; ++j) { m[k][j] *= inverse; }
        for (uint32_t i = 0; i < n; ++i) {
            if (i == k) { continue; }
            const float factor = m[i][k];
            m[i][k] = 0.0f;
            for (uint32_t j = 0; j < n; ++j) { m[i][j] -= factor * m[k][j]; }
        }
    }
}

/* W = (P + sd^2 I)^-1; G = W - W 1 1' W/(1' W 1 + known) with 1/known the variance of what all have in common, 0 where that
   is free. A cylinder alone off by delta explains (G d)_i^2/G_ii of the weighted square, with delta = (G d)_i/G_ii and d
   what the cylinders are off by. */
sd_afr_blame_t sd_afr_joint_blame(const sd_afr_joint_t *self, const sd_afr_usual_t *usual) {
    const uint32_t n = self->config.cylinders;
    sd_afr_blame_t blame = { 0, 0.0f, 0.0f };
    if ((self->running == 0u) || (n < 2u) || !sd_within(usual->sd, 1e-6f, 1.0f)) { return blame; }
    const bool mean_known = sd_within(usual->lambda, -2.0f, 2.0f) && sd_within(usual->lambda_sd, 1e-6f, 1.0f);
    const float lambda = mean_known ? usual->lambda : sd_afr_joint_lambda(self, 0);
    float w[SD_AFR_CYLINDERS_MAX][SD_AFR_CYLINDERS_MAX], row[SD_AFR_CYLINDERS_MAX], common = 0.0f;
    float sum = mean_known ? 1.0f / (usual->lambda_sd * usual->lambda_sd) : 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j < n; ++j) { w[i][j] = self->p.a[i][j] + ((i == j) ? usual->sd * usual->sd : 0.0f); }
    }
    invert(w, n);
    for (uint32_t i = 0; i < n; ++i) {
        row[i] = 0.0f;
        for (uint32_t j = 0; j < n; ++j) { row[i] += w[i][j]; }
        sum += row[i];
        common += row[i] * (sd_afr_joint_lambda(self, i) - lambda);
    }
    common /= sum;
    for (uint32_t i = 0; i < n; ++i) {
        float pull = 0.0f;
        for (uint32_t j = 0; j < n; ++j) { pull += w[i][j] * (sd_afr_joint_lambda(self, j) - lambda - common); }
        const float own = w[i][i] - row[i] * row[i] / sum;
        if (pull * pull > blame.explained * own) { blame = (sd_afr_blame_t){ i, pull / own, pull * pull / own }; }
    }
    return blame;
}

sd_status_t sd_afr_joint_status(const sd_afr_joint_t *self) {
    sd_status_t status = { .rejected = self->rejected, .innovation = self->innovation, .test_ratio = self->test_ratio };
    if (self->running == 0u) {
        status.health = SD_INVALID;
        status.why = SD_WHY_CONVERGING;
    } else if (self->rejected_in_row > 0u) {
        status.health = SD_DEGRADED;
        status.why = SD_WHY_REJECTED;
    }
    return status;
}
