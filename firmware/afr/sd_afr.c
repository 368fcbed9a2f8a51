/* SPDX-License-Identifier: MIT */
#include "sd_afr.h"

#include <string.h>

#include "sd_math.h"

enum { SETTLE = 8, SETTLE_SLOW = 200 }; /* cycles */

#define START_LAMBDA 0.5f
#define REJECT_SD    8.0f
#define REST_LEAST   (1.0f / 6.0f) /* of the drift, at rest */
#define REST_KEEP    0.9f          /* a cycle */
#define TRIM_MOVES   0.004f        /* of fuel, in a cycle */
#define POINT_MOVES  0.005f        /* of speed and intake pressure, in a cycle */

static bool is_chain(const sd_afr_t *self) { return self->config.method != SD_AFR_JOINT; }
static bool is_fixed(const sd_afr_t *self) { return self->config.fixed_point != 0u; }
static bool is_running(const sd_afr_t *self) {
    if (!is_chain(self)) { return self->joint.running != 0u; }
    return (is_fixed(self) ? self->chain_q31.observer.running : self->chain.observer.running) != 0u;
}

static sd_afr_joint_config_t joint_config(const sd_afr_config_t *c, const sd_afr_grid_t *grid) {
    return (sd_afr_joint_config_t){ .cylinders = c->cylinders, .cycle_positions = c->cycle_positions,
                                    .tau1_s = grid->tau1_s, .tau2_s = grid->tau2_s,
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

static sd_afr_point_config_t point_config(const sd_afr_config_t *c) {
    sd_afr_point_config_t point = { .cycle_positions = c->cycle_positions, .cylinders = c->cylinders,
                                    .gain_mass = (c->method == SD_AFR_JOINT) ? 0.0f : c->gain_mass,
                                    .turbine_drop = c->turbine_drop, .turbine_rpm = c->turbine_rpm };
    memcpy(point.firing_position, c->firing_position, sizeof point.firing_position);
    return point;
}

uint8_t sd_afr_harmonics(uint8_t cylinders) { return (cylinders < 4u) ? 1u : (uint8_t)(cylinders / 2u); }

static bool config_ok(const sd_afr_config_t *c) {
    return (c->method >= SD_AFR_JOINT) && (c->method <= SD_AFR_FOURIER) && (c->drift > 0.0f) && (c->drift_slow > 0.0f) &&
           (c->slow_above > 0.0f) && sd_within(c->jump, 0.0f, 1.0f) && ((c->fixed_point == 0u) || (c->method != SD_AFR_JOINT));
}

/* Checks all that the inits check, so that from there on nothing fails. */
static bool blocks_ok(const sd_afr_config_t *config, const sd_afr_tables_t *tables) {
    const sd_afr_point_config_t point = point_config(config);
    if (sd_afr_point_check_f32(&point, tables->grid) != SD_OK) { return false; }
    if (config->method == SD_AFR_JOINT) {
        const sd_afr_joint_config_t joint = joint_config(config, tables->grid);
        return sd_afr_joint_check(&joint) == SD_OK;
    }
    const sd_afr_chain_config_t chain = chain_config(config, tables->grid);
    return (tables->sine_q31 != NULL) && (sd_afr_chain_check_f32(&chain) == SD_OK);
}

sd_result_t sd_afr_init(sd_afr_t *self, const sd_afr_config_t *config, const sd_afr_tables_t *tables) {
    if (!config_ok(config) || !blocks_ok(config, tables)) { return SD_ERR_CONFIG; }
    const sd_afr_point_config_t point = point_config(config);
    const sd_afr_joint_config_t joint = joint_config(config, tables->grid);
    const sd_afr_chain_config_t chain = chain_config(config, tables->grid);
    memset(self, 0, sizeof *self);
    self->config = *config;
    if (is_fixed(self)) {
        (void)sd_afr_point_init_q31(&self->point_q31, &point, tables->grid);
        (void)sd_afr_chain_init_q31(&self->chain_q31, &chain);
    } else {
        (void)sd_afr_point_init_f32(&self->point, &point, tables->grid);
        if (is_chain(self)) { (void)sd_afr_chain_init_f32(&self->chain, &chain); } else { (void)sd_afr_joint_init(&self->joint, &joint); }
    }
    self->mean_lambda = START_LAMBDA;
    self->restless = 1.0f;
    return SD_OK;
}

float sd_afr_drift(const sd_afr_t *self) {
    return (self->slow != 0u) ? self->config.drift_slow : self->restless * self->config.drift;
}

static bool is_near(float now, float before) { return sd_within(now, before * (1.0f - POINT_MOVES), before * (1.0f + POINT_MOVES)); }

/* Whether anything is known to move: the operating point, or a cylinder by itself, which is a jump. */
static void settle(sd_afr_t *self, const sd_afr_conditions_t *at) {
    const sd_afr_conditions_t *before = &self->point.at;
    const bool jumped = self->joint.jumps != self->jumps,
        still = is_near(at->speed_radps, before->speed_radps) && is_near(at->intake_bar, before->intake_bar);
    self->jumps = self->joint.jumps;
    if (jumped || !still || (self->cycles < SETTLE)) { self->restless = 1.0f; return; }
    self->restless *= REST_KEEP;
    if (self->restless < REST_LEAST) { self->restless = REST_LEAST; }
}

static void set_joint(sd_afr_t *self, const sd_afr_grid_t *grid, float speed, float step_s) {
    const float lambda = (self->mean_lambda > 0.05f) ? self->mean_lambda : 0.05f;
    const float drift = sd_afr_drift(self);
    const float tau1_s = grid->tau1_s * (1.0f + self->known.lag), tau2_s = grid->tau2_s * (1.0f + self->known.lag);
    self->doubt = sd_afr_delay_doubt(&self->known, speed, tau1_s, tau2_s);
    self->joint.config.tau1_s = tau1_s;
    self->joint.config.tau2_s = tau2_s;
    sd_afr_joint_set(&self->joint, step_s, lambda * drift, lambda * self->config.jump);
}

static void set_chain(sd_afr_t *self, const sd_afr_tables_t *tables) {
    const bool oscillators = self->config.method == SD_AFR_OSCILLATORS;
    sd_uego_gains_t gains;
    if (is_fixed(self)) {
        if (oscillators) { sd_afr_point_gains_q31(&self->point_q31, tables->grid, &gains); }
        sd_afr_chain_set_q31(&self->chain_q31, tables->sine_q31, self->point_q31.step_s, oscillators ? &gains : NULL,
                             self->point_q31.exhaust.charge);
    } else {
        if (oscillators) { sd_afr_point_gains_f32(&self->point, tables->grid, &gains); }
        sd_afr_chain_set_f32(&self->chain, tables->sine_q31, self->point.step_s, oscillators ? &gains : NULL, self->point.exhaust.charge);
    }
}

static float mean_lambda(const sd_afr_t *self) {
    if (is_fixed(self)) { return sd_scaled_to_float(sd_afr_chain_mean_q31(&self->chain_q31)); }
    float sum = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { sum += sd_afr_lambda(self, i); }
    return sum / (float)self->config.cylinders;
}

void sd_afr_cycle(sd_afr_t *self, const sd_afr_conditions_t *at) {
    if (!(at->speed_radps > 0.0f) || !(at->intake_bar > 0.0f) || !(at->fuel_mg >= 0.0f) || (self->config.cylinders == 0u)) { return; }
    if (is_running(self)) {
        self->mean_lambda = mean_lambda(self);
        if (self->cycles < UINT32_MAX) { self->cycles++; }
    }
    if (!is_chain(self)) { settle(self, at); }
    self->speed_radps = at->speed_radps;
    self->egr_share = sd_within(at->egr_share, 0.0f, SD_AFR_EGR_MAX) ? at->egr_share : 0.0f;
    const float burned_here = (1.0f - self->egr_share) * self->mean_lambda;
    if (is_fixed(self)) {
        (void)sd_afr_point_begin_q31(&self->point_q31, at, sd_scaled_of(burned_here));
    } else {
        (void)sd_afr_point_begin_f32(&self->point, at, burned_here);
    }
}

/* The new point has taken effect in manifold and delay. */
static void take_effect(sd_afr_t *self, const sd_afr_tables_t *tables) {
    const sd_afr_grid_t *grid = tables->grid;
    const float step_s = is_fixed(self) ? self->point_q31.step_s : self->point.step_s;
    const uint8_t slow = (self->speed_radps * (grid->tau1_s + grid->tau2_s) > self->config.slow_above) ? 1u : 0u;
    if (slow != self->slow) { self->cycles = 0; }
    self->slow = slow;
    if (is_chain(self)) { /* its deviation is what it is seen to be off by */
        set_chain(self, tables);
    } else {
        set_joint(self, grid, self->speed_radps, step_s);
    }
    self->placed = 1;
}

bool sd_afr_work(sd_afr_t *self, const sd_afr_tables_t *tables) {
    if (self->config.cylinders == 0u) { return false; }
    const sd_afr_progress_t progress = is_fixed(self) ? sd_afr_point_work_q31(&self->point_q31, tables->grid, self->known.late_s)
                                                      : sd_afr_point_work_f32(&self->point, tables->grid, self->known.late_s);
    if (progress == SD_AFR_SET) { take_effect(self, tables); }
    return progress == SD_AFR_MORE;
}

void sd_afr_correct(sd_afr_t *self, const sd_afr_learned_t *known) {
    const bool ok = (known->late_s >= -0.05f) && (known->late_s <= 0.05f) && (known->lag >= -0.5f) && (known->lag <= 0.5f) &&
                    (known->late_sd_s >= 0.0f) && (known->late_sd_s < 1.0f) && (known->lag_sd >= 0.0f) && (known->lag_sd < 10.0f);
    if (ok) { self->known = *known; }
}

void sd_afr_restart(sd_afr_t *self) {
    if (!is_chain(self)) {
        sd_afr_joint_restart(&self->joint);
    } else if (is_fixed(self)) {
        sd_afr_chain_restart_q31(&self->chain_q31);
    } else {
        sd_afr_chain_restart_f32(&self->chain);
    }
    self->cycles = 0;
}

/* The delay learns from floats. */
static void inflow_of_q31(const sd_exhaust_now_q31_t *now, sd_afr_inflow_t *in) {
    sd_exhaust_now_f32_t f = { .mass = sd_to_float_q31(now->mass), .charge = sd_to_float_q31(now->charge), .count = now->count };
    for (uint32_t k = 0; k < now->count; ++k) {
        f.flowing[k] = now->flowing[k];
        f.share[now->flowing[k]] = sd_to_float_q31(now->share[now->flowing[k]]);
    }
    sd_afr_inflow_of(&f, in);
}

static void step_q31(sd_afr_t *self, const sd_afr_tables_t *tables, uint32_t cycle_position, float air, float exhaust_bar) {
    sd_exhaust_now_q31_t now;
    sd_exhaust_step_q31(&self->point_q31.exhaust, tables->grid->psi_q31, cycle_position, &now);
    if (exhaust_bar > 0.0f) { sd_exhaust_measured_q31(&self->point_q31.exhaust, sd_from_float_q31(exhaust_bar * (1.0f / SD_EXHAUST_BAR))); }
    inflow_of_q31(&now, &self->in);
    sd_afr_chain_step_q31(&self->chain_q31, tables->sine_q31, &now, cycle_position, sd_from_float_q31(air));
}

void sd_afr_step(sd_afr_t *self, const sd_afr_tables_t *tables, uint32_t cycle_position, float lambda, float exhaust_bar) {
    if (self->placed == 0u) { return; }
    const float air = (lambda < 2.0f) ? 1.0f - lambda : SD_AFR_NO_SAMPLE;
    if (is_fixed(self)) {
        step_q31(self, tables, cycle_position, air, exhaust_bar);
    } else {
        sd_exhaust_now_f32_t now;
        sd_exhaust_step_f32(&self->point.exhaust, tables->grid->psi, cycle_position, &now);
        if (exhaust_bar > 0.0f) { sd_exhaust_measured_f32(&self->point.exhaust, exhaust_bar * (1.0f / SD_EXHAUST_BAR)); }
        sd_afr_inflow_of(&now, &self->in);
        if (is_chain(self)) {
            sd_afr_chain_step_f32(&self->chain, tables->sine_q31, &now, cycle_position, air);
        } else {
            sd_afr_joint_step(&self->joint, &self->in, air, NULL);
        }
    }
    if (!is_running(self)) { self->cycles = 0; }
}

void sd_afr_trimmed(sd_afr_t *self, uint32_t cylinder, float fuel_factor) {
    const float change = (fuel_factor - 1.0f) * (1.0f - self->egr_share) * sd_afr_lambda(self, cylinder);
    if (!sd_within(fuel_factor, 1.0f - TRIM_MOVES, 1.0f + TRIM_MOVES)) { self->restless = 1.0f; }
    if (!is_chain(self)) {
        sd_afr_joint_move(&self->joint, cylinder, change);
    } else if (is_fixed(self)) {
        sd_afr_chain_move_q31(&self->chain_q31, cylinder, change);
    } else {
        sd_afr_chain_move_f32(&self->chain, cylinder, change);
    }
}

float sd_afr_lambda(const sd_afr_t *self, uint32_t cylinder) {
    if (!is_chain(self)) { return sd_afr_joint_lambda(&self->joint, cylinder); }
    return is_fixed(self) ? sd_afr_chain_lambda_q31(&self->chain_q31, cylinder) : sd_afr_chain_lambda_f32(&self->chain, cylinder);
}

static void read_joint(const sd_afr_t *self, sd_afr_estimate_t *out) {
    const uint32_t n = self->config.cylinders;
    memset(out, 0, sizeof *out);
    if (!is_running(self)) { return; }
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
    sd_afr_joint_deviation_variances(&self->joint, variance);
    /* An error of the model turns one cylinder's deviation into all the others'. */
    const float model = self->doubt * square / (float)n + 1e-12f;
    for (uint32_t i = 0; i < n; ++i) { out->sd[i] = sd_root(variance[i] * inverse * inverse + model); }
}

void sd_afr_read(const sd_afr_t *self, sd_afr_estimate_t *out) {
    if (self->config.cylinders == 0u) {
        memset(out, 0, sizeof *out);
    } else if (!is_chain(self)) {
        read_joint(self, out);
    } else if (is_fixed(self)) {
        sd_afr_chain_read_q31(&self->chain_q31, out);
    } else {
        sd_afr_chain_read_f32(&self->chain, out);
    }
}

static sd_status_t block_status(const sd_afr_t *self) {
    if (!is_chain(self)) { return sd_afr_joint_status(&self->joint); }
    return is_fixed(self) ? sd_afr_chain_status_q31(&self->chain_q31) : sd_afr_chain_status_f32(&self->chain);
}

sd_status_t sd_afr_status(const sd_afr_t *self) {
    sd_status_t status = block_status(self);
    const bool settled = (self->slow != 0u) ? !is_chain(self) && (self->cycles >= SETTLE_SLOW) : (self->cycles >= SETTLE);
    if ((status.health == SD_VALID) && !settled) {
        status.health = SD_DEGRADED;
        status.why |= SD_WHY_CONVERGING;
    }
    return status;
}
