/* SPDX-License-Identifier: MIT */
#include "sd_afr_joint.h"

#include <string.h>

#include "sd_math.h"

enum { REJECTED_IN_ROW_MAX = 60, /* samples left out in a row after which the estimate must be wrong */
       JUMP_HOLD = 120,          /* samples, about a cycle, until the next jump may be seen */
       X = 0 };

#define MEAN_PACE 0.06f /* the mean of innovations reaches back about 1/this samples */
#define MEAN_MAX  0.77f /* its square over the innovation's variance: 5 standard deviations of such a mean, sqrt(pace/(2 - pace)) */

static uint32_t states(const sd_afr_joint_t *self) { return self->config.cylinders + 3u; }

static float *entry(sd_afr_joint_t *self, uint32_t i, uint32_t j) {
    return &self->covariance[(i >= j) ? i * (i + 1u) / 2u + j : j * (j + 1u) / 2u + i];
}

sd_result_t sd_afr_joint_check(const sd_afr_joint_config_t *c) {
    const bool ok = (c->cylinders >= 1u) && (c->cylinders <= SD_AFR_CYLINDERS_MAX) && sd_within(c->tau1_s, 1e-4f, 1.0f) &&
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

void sd_afr_joint_set(sd_afr_joint_t *self, float step_s, float drift, float jump) {
    if (!(step_s > 0.0f) || !(step_s <= 0.1f) || !sd_within(drift, 1e-6f, 1.0f) || !sd_within(jump, 0.0f, 1.0f)) { return; }
    self->move2 = sd_lag_move(step_s / self->config.tau2_s);
    self->move1 = sd_lag_move(step_s / self->config.tau1_s);
    self->noise_var = self->config.noise_per_rthz * self->config.noise_per_rthz / (2.0f * step_s);
    self->drift_var = drift * drift;
    self->jump_var = jump * jump;
}

void sd_afr_joint_restart(sd_afr_joint_t *self) { self->running = 0; }

static void begin(sd_afr_joint_t *self, float measured) {
    const uint32_t n = states(self);
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { self->air_fraction[i] = measured; }
    self->x = self->lag2 = self->lag1 = measured;
    memset(self->covariance, 0, sizeof self->covariance);
    for (uint32_t i = 0; i < n; ++i) { *entry(self, i, i) = self->config.start_sd * self->config.start_sd; }
    self->steps = 0;
    self->rejected_in_row = 0;
    self->mean_innovation = 0.0f;
    self->hold = JUMP_HOLD;
    self->running = 1;
}

/* State `row` becomes keep times itself plus share times state `other`; their covariances follow. */
static void blend(sd_afr_joint_t *self, uint32_t row, float keep, uint32_t other, float share) {
    const uint32_t n = states(self);
    const float own = *entry(self, row, row), cross = *entry(self, row, other);
    for (uint32_t j = 0; j < n; ++j) {
        if (j != row) { *entry(self, row, j) = keep * *entry(self, row, j) + share * *entry(self, other, j); }
    }
    *entry(self, row, row) = keep * (keep * own + 2.0f * share * cross) + share * share * *entry(self, other, other);
}

/* One cylinder after the other: the same as all at once, since what is mixed in first is diluted by what follows. */
static void mix(sd_afr_joint_t *self, const sd_exhaust_now_f32_t *now, bool with_covariance) {
    float mass = now->mass; /* after the position: before it, without what flowed in */
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { mass -= now->charge * now->share[i]; }
    if (!(mass > 0.0f)) { mass = 0.0f; }
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        const bool flows = now->share[i] > 0.0f;
        if (flows) {
            const float added = now->charge * now->share[i], share = added / (mass + added);
            if (with_covariance && (self->flowing[i] == 0u)) { *entry(self, 1u + i, 1u + i) += self->drift_var; }
            self->x += share * (self->air_fraction[i] - self->x);
            if (with_covariance) { blend(self, X, 1.0f - share, 1u + i, share); }
            mass += added;
        }
        self->flowing[i] = flows ? 1u : 0u;
    }
}

static void lag(sd_afr_joint_t *self, bool with_covariance) {
    const uint32_t s2 = self->config.cylinders + 1u, s1 = s2 + 1u;
    self->lag2 += self->move2 * (self->x - self->lag2);
    self->lag1 += self->move1 * (self->lag2 - self->lag1);
    if (with_covariance) {
        blend(self, s2, 1.0f - self->move2, X, self->move2);
        blend(self, s1, 1.0f - self->move1, s2, self->move1);
    }
}

static void correct(sd_afr_joint_t *self, const float *k, float error) {
    const uint32_t n = self->config.cylinders;
    self->x += k[X] * error;
    for (uint32_t i = 0; i < n; ++i) { self->air_fraction[i] += k[1u + i] * error; }
    self->lag2 += k[n + 1u] * error;
    self->lag1 += k[n + 2u] * error;
}

/* Innovations that keep to one side: something has moved more than drift allows. Which cylinder is for the samples to say:
   all states are let go alike, the sensor's too, since they have followed the wrong gas until now. */
static void watch(sd_afr_joint_t *self, float error, float inverse) {
    self->mean_innovation += MEAN_PACE * (error - self->mean_innovation);
    if (self->hold > 0u) { self->hold--; }
    const float square = self->mean_innovation * self->mean_innovation * inverse;
    if ((square < MEAN_MAX) || (self->hold > 0u) || !(self->jump_var > 0.0f)) { return; }
    for (uint32_t i = 0; i < states(self); ++i) { *entry(self, i, i) += self->jump_var; }
    self->mean_innovation = 0.0f;
    self->hold = JUMP_HOLD;
    if (self->jumps < UINT16_MAX) { self->jumps++; }
}

/* K = P h / (h' P h + R) with h the last state; P -= K h' P. */
static void update(sd_afr_joint_t *self, float error) {
    const uint32_t n = states(self), s1 = n - 1u;
    float column[SD_AFR_STATES_MAX], k[SD_AFR_STATES_MAX];
    const float inverse = 1.0f / (*entry(self, s1, s1) + self->noise_var);
    self->test_ratio = error * error * inverse / (self->config.reject * self->config.reject);
    if (self->test_ratio > 1.0f) {
        if (self->rejected < UINT16_MAX) { self->rejected++; }
        if (++self->rejected_in_row > REJECTED_IN_ROW_MAX) { self->running = 0; }
        return;
    }
    self->rejected_in_row = 0;
    for (uint32_t i = 0; i < n; ++i) {
        column[i] = *entry(self, i, s1);
        k[i] = column[i] * inverse;
    }
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j <= i; ++j) { *entry(self, i, j) -= k[i] * column[j]; }
        if (*entry(self, i, i) < 1e-12f) { *entry(self, i, i) = 1e-12f; } /* rounding must not make it negative */
    }
    correct(self, k, error);
    watch(self, error, inverse);
}

void sd_afr_joint_step(sd_afr_joint_t *self, const sd_exhaust_now_f32_t *now, float measured, const float *gains) {
    const bool seen = (measured > -2.0f) && (measured < 2.0f);
    if (self->running == 0u) {
        if (seen) { begin(self, measured); }
        return;
    }
    mix(self, now, gains == 0);
    lag(self, gains == 0);
    if (seen) {
        self->innovation = measured - self->lag1;
        if (gains != 0) { correct(self, gains, self->innovation); } else { update(self, self->innovation); }
    }
    if (!((self->x > -4.0f) && (self->x < 4.0f))) { self->running = 0; } /* or NaN: begins anew */
    if (self->steps < UINT32_MAX) { self->steps++; }
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
    sd_afr_joint_t *s = (sd_afr_joint_t *)self; /* entry() only reads here */
    float all = 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        float row = 0.0f;
        for (uint32_t j = 0; j < n; ++j) { row += *entry(s, 1u + i, 1u + j); }
        all += row;
        variance[i] = *entry(s, 1u + i, 1u + i) - 2.0f * part * row;
    }
    for (uint32_t i = 0; i < n; ++i) { variance[i] += part * part * all; }
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
    sd_afr_joint_t *s = (sd_afr_joint_t *)self; /* entry() only reads here */
    const bool mean_known = sd_within(usual->lambda, -2.0f, 2.0f) && sd_within(usual->lambda_sd, 1e-6f, 1.0f);
    const float lambda = mean_known ? usual->lambda : sd_afr_joint_lambda(self, 0);
    float w[SD_AFR_CYLINDERS_MAX][SD_AFR_CYLINDERS_MAX], row[SD_AFR_CYLINDERS_MAX], common = 0.0f;
    float sum = mean_known ? 1.0f / (usual->lambda_sd * usual->lambda_sd) : 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j < n; ++j) { w[i][j] = *entry(s, 1u + i, 1u + j) + ((i == j) ? usual->sd * usual->sd : 0.0f); }
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
