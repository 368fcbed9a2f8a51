/* SPDX-License-Identifier: MIT */
#include "sd_afr.h"

#include <string.h>

#include "sd_math.h"

enum { SETTLE = 8, SETTLE_SLOW = 200 }; /* cycles */

#define START_LAMBDA 0.5f
#define REJECT_SD    8.0f
#define LAG_LEAD     SD_UEGO_LEAD /* of the filter's lags as well: docs/afr.md */

static bool is_chain(const sd_afr_t *self) { return self->config.method != SD_AFR_JOINT; }
static bool is_running(const sd_afr_t *self) {
    return (is_chain(self) ? self->chain.observer.running : self->joint.running) != 0u;
}

static sd_afr_joint_config_t joint_config(const sd_afr_config_t *c, const sd_afr_grid_t *grid) {
    return (sd_afr_joint_config_t){ .cylinders = c->cylinders, .tau1_s = grid->tau1_s, .tau2_s = grid->tau2_s,
                                    .noise_per_rthz = c->noise_per_rthz, .drift = c->drift * START_LAMBDA,
                                    .start_sd = 0.1f, .reject = REJECT_SD };
}

static sd_afr_chain_config_t chain_config(const sd_afr_config_t *c, const sd_afr_grid_t *grid) {
    return (sd_afr_chain_config_t){ .cycle_positions = c->cycle_positions, .cylinders = c->cylinders,
                                    .harmonics = sd_afr_harmonics(c->cylinders), .settle_steps = 0,
                                    .tau1_s = grid->tau1_s, .tau2_s = grid->tau2_s,
                                    .gain_air = c->gain_air, .gain_cylinder = c->gain_cylinder,
                                    .inversion_gain = c->inversion_gain, .inversion_floor = c->inversion_floor };
}

uint8_t sd_afr_harmonics(uint8_t cylinders) { return (cylinders < 4u) ? 1u : (uint8_t)(cylinders / 2u); }

static bool config_ok(const sd_afr_config_t *c, const sd_afr_grid_t *grid) {
    bool ok = (grid->present != 0u) && (c->method >= SD_AFR_JOINT) && (c->method <= SD_AFR_FOURIER) && (c->drift > 0.0f) &&
              (c->drift_slow > 0.0f) && (c->slow_above > 0.0f) && sd_within(c->jump, 0.0f, 1.0f);
    for (uint32_t k = 0; ok && (k <= SD_EXHAUST_PSI); ++k) { ok = (grid->psi[k] >= 0.0f) && (grid->psi[k] < 1.0f); }
    return ok;
}

sd_result_t sd_afr_init(sd_afr_t *self, const sd_afr_config_t *config, const sd_afr_tables_t *tables) {
    const sd_afr_grid_t *grid = tables->grid;
    sd_exhaust_config_t exhaust = { .cycle_positions = config->cycle_positions, .cylinders = config->cylinders,
                                    .open_position = grid->open_position, .mass_base_kg = grid->mass_base_kg };
    memcpy(exhaust.firing_position, config->firing_position, sizeof exhaust.firing_position);
    if (!config_ok(config, grid) || (sd_exhaust_check_f32(&exhaust) != SD_OK)) { return SD_ERR_CONFIG; }
    const sd_afr_joint_config_t joint = joint_config(config, grid);
    const sd_afr_chain_config_t chain = chain_config(config, grid);
    const bool is_joint = config->method == SD_AFR_JOINT;
    if (is_joint && (sd_afr_joint_check(&joint) != SD_OK)) { return SD_ERR_CONFIG; }
    if (!is_joint && ((tables->sine_q31 == NULL) || (sd_afr_chain_check_f32(&chain) != SD_OK))) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self); /* from here on nothing fails */
    self->config = *config;
    (void)sd_exhaust_init_f32(&self->exhaust, &exhaust);
    if (is_joint) { (void)sd_afr_joint_init(&self->joint, &joint); } else { (void)sd_afr_chain_init_f32(&self->chain, &chain); }
    self->mean_lambda = START_LAMBDA;
    self->coming.piece = SD_AFR_PIECES;
    return SD_OK;
}

/* Which interval of an ascending axis holds x, and where in it, cut to [0, 1]. */
static uint32_t place(const float *axis, uint32_t count, float x, float *share) {
    uint32_t at = 0;
    while ((at + 2u < count) && (x > axis[at + 1u])) { at++; }
    const float t = (x - axis[at]) / (axis[at + 1u] - axis[at]);
    *share = (t > 1.0f) ? 1.0f : (t > 0.0f) ? t : 0.0f;
    return at;
}

enum { CORNERS = 8 };

/* The eight nodes around the coming point, and how much of each counts. */
static void find_corners(const sd_afr_coming_t *c, const sd_afr_grid_t *grid, const sd_afr_node_t *node[CORNERS], float weight[CORNERS]) {
    const float low = 1.0f - c->part[0], lean = 1.0f - c->part[2];
    for (uint32_t j = 0; j < 2u; ++j) {
        const float along = (j != 0u) ? c->part[1] : 1.0f - c->part[1], slower = low * along, faster = c->part[0] * along;
        for (uint32_t k = 0; k < 2u; ++k) {
            const float part = (k != 0u) ? c->part[2] : lean;
            const uint32_t corner = 4u * k + 2u * j;
            node[corner] = &grid->node[c->node[0]][c->node[1] + j][c->node[2] + k];
            node[corner + 1u] = &grid->node[c->node[0] + 1u][c->node[1] + j][c->node[2] + k];
            weight[corner] = slower * part;
            weight[corner + 1u] = faster * part;
        }
    }
}

/* First piece: where the point is, and all of it but the shares. */
static void place_point(sd_afr_t *self, const sd_afr_grid_t *grid) {
    sd_afr_coming_t *c = &self->coming;
    const sd_afr_node_t *node[CORNERS];
    float w[CORNERS];
    c->node[0] = (uint8_t)place(grid->speed_radps, SD_AFR_SPEEDS, c->speed_radps, &c->part[0]);
    c->node[1] = (uint8_t)place(grid->pressure_bar, SD_AFR_PRESSURES, c->intake_bar, &c->part[1]);
    c->node[2] = (uint8_t)place(grid->lambda, SD_AFR_LAMBDAS, self->mean_lambda, &c->part[2]);
    find_corners(c, grid, node, w);
    c->rate_hz = c->z0_kg = c->transport_kg = 0.0f;
    for (uint32_t corner = 0; corner < CORNERS; ++corner) {
        c->rate_hz += w[corner] * node[corner]->rate_hz;
        c->z0_kg += w[corner] * node[corner]->z0_kg;
        c->transport_kg += w[corner] * node[corner]->transport_kg;
    }
}

/* SD_AFR_PIECE shares of it. */
static void mix_shares(sd_afr_t *self, const sd_afr_grid_t *grid, uint32_t first) {
    const sd_afr_node_t *of[CORNERS];
    float w[CORNERS], share[SD_AFR_PIECE];
    find_corners(&self->coming, grid, of, w);
    for (uint32_t k = 0; k < SD_AFR_PIECE; ++k) { /* written out: a loop over the corners would cost twice as much */
        const uint32_t n = first + k;
        share[k] = w[0] * (float)of[0]->share[n] + w[1] * (float)of[1]->share[n] + w[2] * (float)of[2]->share[n] +
                   w[3] * (float)of[3]->share[n] + w[4] * (float)of[4]->share[n] + w[5] * (float)of[5]->share[n] +
                   w[6] * (float)of[6]->share[n] + w[7] * (float)of[7]->share[n];
        share[k] *= 1.0f / 65536.0f;
    }
    (void)sd_exhaust_shares_f32(&self->exhaust, first, SD_AFR_PIECE, share);
}

/* The oscillators' gains at a speed. */
static sd_uego_gains_t inversion_gains(const sd_afr_grid_t *grid, float speed) {
    float part;
    const uint32_t s = place(grid->speed_radps, SD_AFR_SPEEDS, speed, &part);
    const sd_uego_gains_t *low = &grid->inversion[s], *high = &grid->inversion[s + 1u];
    sd_uego_gains_t gains;
    for (uint32_t k = 0; k <= SD_UEGO_HARMONICS_MAX; ++k) {
        gains.re[k] = low->re[k] + part * (high->re[k] - low->re[k]);
        gains.im[k] = low->im[k] + part * (high->im[k] - low->im[k]);
    }
    gains.lag2 = low->lag2 + part * (high->lag2 - low->lag2);
    gains.lag1 = low->lag1 + part * (high->lag1 - low->lag1);
    return gains;
}

static void set_joint(sd_afr_t *self, const sd_afr_grid_t *grid, float speed, float step_s) {
    const float lambda = (self->mean_lambda > 0.05f) ? self->mean_lambda : 0.05f;
    const float drift = (self->slow != 0u) ? self->config.drift_slow : self->config.drift;
    const float tau1_s = grid->tau1_s * (1.0f + self->known.lag), tau2_s = grid->tau2_s * (1.0f + self->known.lag);
    self->doubt = sd_afr_delay_doubt(&self->known, speed, tau1_s, tau2_s);
    self->joint.config.tau1_s = tau1_s;
    self->joint.config.tau2_s = tau2_s;
    sd_afr_joint_set(&self->joint, step_s, lambda * drift, lambda * self->config.jump);
}

static void set_chain(sd_afr_t *self, const sd_afr_tables_t *tables, float speed, float step_s) {
    const sd_uego_gains_t gains = inversion_gains(tables->grid, speed);
    const sd_uego_gains_t *oscillators = (self->config.method == SD_AFR_OSCILLATORS) ? &gains : NULL;
    sd_afr_chain_set_f32(&self->chain, tables->sine_q31, step_s, oscillators, self->exhaust.charge);
}

void sd_afr_cycle(sd_afr_t *self, float speed_radps, float intake_bar, float fuel_mg) {
    if (!(speed_radps > 0.0f) || !(intake_bar > 0.0f) || !(fuel_mg >= 0.0f) || (self->config.cylinders == 0u)) { return; }
    float sum = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { sum += sd_afr_lambda(self, i); }
    if (is_running(self)) {
        self->mean_lambda = sum / (float)self->config.cylinders;
        if (self->cycles < UINT32_MAX) { self->cycles++; }
    }
    self->coming.speed_radps = speed_radps;
    self->coming.intake_bar = intake_bar;
    self->coming.fuel_mg = fuel_mg;
    self->coming.piece = 0;
}

/* Last piece: the new point takes effect. */
static void take_effect(sd_afr_t *self, const sd_afr_tables_t *tables) {
    const sd_afr_grid_t *grid = tables->grid;
    const sd_afr_coming_t *c = &self->coming;
    const float step_s = 2.0f * SD_TWO_PI / (c->speed_radps * (float)self->config.cycle_positions);
    const sd_exhaust_point_t point = { .charge_kg = grid->air_kg_per_bar * c->intake_bar + 1e-6f * c->fuel_mg, .rate_hz = c->rate_hz,
                                       .z0_kg = c->z0_kg, .pipe_kg = c->transport_kg,
                                       .delay_positions = (grid->dead_s + self->known.late_s) / step_s + LAG_LEAD };
    if (sd_exhaust_set_f32(&self->exhaust, &point, step_s) != SD_OK) { return; }
    const uint8_t slow = (c->speed_radps * (grid->tau1_s + grid->tau2_s) > self->config.slow_above) ? 1u : 0u;
    if (slow != self->slow) { self->cycles = 0; }
    self->slow = slow;
    if (is_chain(self)) { /* its deviation is what it is seen to be off by */
        set_chain(self, tables, c->speed_radps, step_s);
    } else {
        set_joint(self, grid, c->speed_radps, step_s);
    }
    self->placed = 1;
}

bool sd_afr_work(sd_afr_t *self, const sd_afr_tables_t *tables) {
    const uint32_t piece = self->coming.piece;
    if ((piece >= SD_AFR_PIECES) || (self->config.cylinders == 0u)) { return false; }
    if (piece == 0u) {
        place_point(self, tables->grid);
    } else if (piece < SD_AFR_PIECES - 1u) {
        mix_shares(self, tables->grid, (piece - 1u) * SD_AFR_PIECE);
    } else {
        take_effect(self, tables);
    }
    self->coming.piece++;
    return self->coming.piece < SD_AFR_PIECES;
}

void sd_afr_correct(sd_afr_t *self, const sd_afr_learned_t *known) {
    const bool ok = (known->late_s >= -0.05f) && (known->late_s <= 0.05f) && (known->lag >= -0.5f) && (known->lag <= 0.5f) &&
                    (known->late_sd_s >= 0.0f) && (known->late_sd_s < 1.0f) && (known->lag_sd >= 0.0f) && (known->lag_sd < 10.0f);
    if (ok) { self->known = *known; }
}

void sd_afr_restart(sd_afr_t *self) {
    if (is_chain(self)) { sd_afr_chain_restart_f32(&self->chain); } else { sd_afr_joint_restart(&self->joint); }
    self->cycles = 0;
}

void sd_afr_step(sd_afr_t *self, const sd_afr_tables_t *tables, uint32_t cycle_position, float lambda) {
    if (self->placed == 0u) { return; }
    sd_exhaust_now_f32_t now;
    sd_exhaust_step_f32(&self->exhaust, tables->grid->psi, cycle_position, &now);
    sd_afr_inflow_of(&now, &self->in);
    const float air = (lambda < 2.0f) ? 1.0f - lambda : SD_AFR_NO_SAMPLE;
    if (is_chain(self)) {
        sd_afr_chain_step_f32(&self->chain, tables->sine_q31, &now, cycle_position, air);
    } else {
        sd_afr_joint_step(&self->joint, &self->in, air, NULL);
    }
    if (!is_running(self)) { self->cycles = 0; }
}

void sd_afr_trimmed(sd_afr_t *self, uint32_t cylinder, float fuel_factor) {
    const float change = (fuel_factor - 1.0f) * sd_afr_lambda(self, cylinder);
    if (is_chain(self)) {
        sd_afr_chain_move_f32(&self->chain, cylinder, change);
    } else {
        sd_afr_joint_move(&self->joint, cylinder, change);
    }
}

float sd_afr_lambda(const sd_afr_t *self, uint32_t cylinder) {
    return is_chain(self) ? sd_afr_chain_lambda_f32(&self->chain, cylinder) : sd_afr_joint_lambda(&self->joint, cylinder);
}

void sd_afr_read(const sd_afr_t *self, sd_afr_estimate_t *out) {
    const uint32_t n = self->config.cylinders;
    memset(out, 0, sizeof *out);
    if ((n == 0u) || !is_running(self)) { return; }
    float variance[SD_AFR_CYLINDERS_MAX], mean = 0.0f, square = 0.0f;
    for (uint32_t i = 0; i < n; ++i) {
        out->lambda[i] = sd_afr_lambda(self, i);
        mean += out->lambda[i];
    }
    mean /= (float)n;
    if (!(mean > 0.02f)) { mean = 0.02f; } /* in fuel cut there is no mixture to be off from */
    const float inverse = 1.0f / mean;
    for (uint32_t i = 0; i < n; ++i) {
        out->deviation[i] = out->lambda[i] / mean - 1.0f;
        square += out->deviation[i] * out->deviation[i];
    }
    if (is_chain(self)) {
        const float alike = sd_afr_chain_deviation_variance_f32(&self->chain);
        for (uint32_t i = 0; i < n; ++i) { variance[i] = alike; }
    } else {
        sd_afr_joint_deviation_variances(&self->joint, variance);
    }
    /* An error of the model turns one cylinder's deviation into all the others'. */
    const float model = self->doubt * square / (float)n + 1e-12f;
    for (uint32_t i = 0; i < n; ++i) { out->sd[i] = sd_root(variance[i] * inverse * inverse + model); }
}

sd_status_t sd_afr_status(const sd_afr_t *self) {
    sd_status_t status = is_chain(self) ? sd_afr_chain_status_f32(&self->chain) : sd_afr_joint_status(&self->joint);
    const bool settled = (self->slow != 0u) ? !is_chain(self) && (self->cycles >= SETTLE_SLOW) : (self->cycles >= SETTLE);
    if ((status.health == SD_VALID) && !settled) {
        status.health = SD_DEGRADED;
        status.why |= SD_WHY_CONVERGING;
    }
    return status;
}
