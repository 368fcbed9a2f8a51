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

static sd_result_t init_joint(sd_afr_t *self, const sd_afr_grid_t *grid) {
    const sd_afr_config_t *c = &self->config;
    const sd_afr_joint_config_t joint = { .cylinders = c->cylinders, .tau1_s = grid->tau1_s, .tau2_s = grid->tau2_s,
                                          .noise_per_rthz = c->noise_per_rthz, .drift = c->drift * START_LAMBDA,
                                          .start_sd = 0.1f, .reject = REJECT_SD };
    return sd_afr_joint_init(&self->joint, &joint);
}

static sd_result_t init_chain(sd_afr_t *self, const sd_afr_grid_t *grid, const int32_t *sine_q31) {
    const sd_afr_config_t *c = &self->config;
    const sd_afr_chain_config_t chain = { .cycle_positions = c->cycle_positions, .cylinders = c->cylinders,
                                          .harmonics = sd_afr_harmonics(c->cylinders), .settle_steps = 0,
                                          .tau1_s = grid->tau1_s, .tau2_s = grid->tau2_s,
                                          .gain_air = c->gain_air, .gain_cylinder = c->gain_cylinder,
                                          .inversion_gain = c->inversion_gain, .inversion_floor = c->inversion_floor,
                                          .sine_q31 = sine_q31 };
    return (sine_q31 != NULL) ? sd_afr_chain_init_f32(&self->chain, &chain) : SD_ERR_CONFIG;
}

uint8_t sd_afr_harmonics(uint8_t cylinders) { return (cylinders < 4u) ? 1u : (uint8_t)(cylinders / 2u); }

sd_result_t sd_afr_init(sd_afr_t *self, const sd_afr_config_t *config, const sd_afr_grid_t *grid, const int32_t *sine_q31) {
    if ((grid->present == 0u) || !((config->drift > 0.0f) && (config->drift_slow > 0.0f) && (config->slow_above > 0.0f) && (config->jump >= 0.0f) && (config->jump <= 1.0f))) {
        return SD_ERR_CONFIG;
    }
    if ((config->method < SD_AFR_JOINT) || (config->method > SD_AFR_FOURIER)) { return SD_ERR_CONFIG; }
    sd_exhaust_config_t exhaust = { .cycle_positions = config->cycle_positions, .cylinders = config->cylinders,
                                    .mass_base_kg = grid->mass_base_kg };
    memcpy(exhaust.firing_position, config->firing_position, sizeof exhaust.firing_position);
    memcpy(exhaust.psi, grid->psi, sizeof exhaust.psi);
    sd_afr_t fresh;
    memset(&fresh, 0, sizeof fresh);
    fresh.config = *config;
    if (sd_exhaust_init_f32(&fresh.exhaust, &exhaust) != SD_OK) { return SD_ERR_CONFIG; }
    if ((is_chain(&fresh) ? init_chain(&fresh, grid, sine_q31) : init_joint(&fresh, grid)) != SD_OK) { return SD_ERR_CONFIG; }
    *self = fresh;
    self->mean_lambda = START_LAMBDA;
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

/* Trilinear, node by node; leaves rate, z0 and the gas between turbine and sensor in *sum, shares in self. */
static void interpolate(sd_afr_t *self, const sd_afr_grid_t *grid, float speed, float pressure, sd_afr_node_t *sum) {
    float part[3];
    const uint32_t s = place(grid->speed_radps, SD_AFR_SPEEDS, speed, &part[0]);
    const uint32_t p = place(grid->pressure_bar, SD_AFR_PRESSURES, pressure, &part[1]);
    const uint32_t l = place(grid->lambda, SD_AFR_LAMBDAS, self->mean_lambda, &part[2]);
    const uint32_t cycle = self->config.cycle_positions;
    memset(sum, 0, sizeof *sum);
    memset(self->share, 0, sizeof self->share);
    for (uint32_t corner = 0; corner < 8u; ++corner) {
        const uint32_t i = corner & 1u, j = (corner >> 1) & 1u, k = corner >> 2;
        const sd_afr_node_t *node = &grid->node[s + i][p + j][l + k];
        const float weight = ((i != 0u) ? part[0] : 1.0f - part[0]) * ((j != 0u) ? part[1] : 1.0f - part[1]) *
                             ((k != 0u) ? part[2] : 1.0f - part[2]);
        sum->rate_hz += weight * node->rate_hz;
        sum->z0_kg += weight * node->z0_kg;
        sum->transport_kg += weight * node->transport_kg;
        for (uint32_t n = 0; (n < SD_AFR_OPEN) && (n < cycle); ++n) {
            self->share[(grid->open_position + n) % cycle] += weight * (float)node->share[n] * (1.0f / 65536.0f);
        }
    }
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

static void set_joint(sd_afr_t *self, float step_s) {
    const float lambda = (self->mean_lambda > 0.05f) ? self->mean_lambda : 0.05f;
    const float drift = (self->slow != 0u) ? self->config.drift_slow : self->config.drift;
    sd_afr_joint_set(&self->joint, step_s, lambda * drift, lambda * self->config.jump);
}

static void set_chain(sd_afr_t *self, const sd_afr_grid_t *grid, float speed, float step_s) {
    const sd_uego_gains_t gains = inversion_gains(grid, speed);
    sd_afr_chain_set_f32(&self->chain, step_s, (self->config.method == SD_AFR_OSCILLATORS) ? &gains : NULL, self->exhaust.charge);
}

void sd_afr_cycle(sd_afr_t *self, const sd_afr_grid_t *grid, float speed_radps, float intake_bar, float fuel_mg) {
    if (!(speed_radps > 0.0f) || !(intake_bar > 0.0f) || !(fuel_mg >= 0.0f)) { return; }
    float sum = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { sum += sd_afr_lambda(self, i); }
    if (is_running(self)) { self->mean_lambda = sum / (float)self->config.cylinders; }
    sd_afr_node_t node;
    interpolate(self, grid, speed_radps, intake_bar, &node);
    const float step_s = (2.0f * SD_TWO_PI) / (speed_radps * (float)self->config.cycle_positions);
    const float charge_kg = grid->air_kg_per_bar * intake_bar + 1e-6f * fuel_mg;
    const sd_exhaust_point_t point = { .share = self->share, .charge_kg = charge_kg, .rate_hz = node.rate_hz, .z0_kg = node.z0_kg,
                                       .pipe_kg = node.transport_kg, .delay_positions = (grid->dead_s + self->known.late_s) / step_s + LAG_LEAD };
    if (sd_exhaust_set_f32(&self->exhaust, &point, step_s) != SD_OK) { return; }
    const float tau1_s = grid->tau1_s * (1.0f + self->known.lag), tau2_s = grid->tau2_s * (1.0f + self->known.lag);
    if (!is_chain(self)) { /* the chain's deviation is what it is seen to be off by */
        self->doubt = sd_afr_delay_doubt(&self->known, speed_radps, tau1_s, tau2_s);
        self->joint.config.tau1_s = tau1_s;
        self->joint.config.tau2_s = tau2_s;
    }
    const uint8_t slow = (speed_radps * (grid->tau1_s + grid->tau2_s) > self->config.slow_above) ? 1u : 0u;
    if (slow != self->slow) { self->cycles = 0; }
    self->slow = slow;
    if (is_chain(self)) { set_chain(self, grid, speed_radps, step_s); } else { set_joint(self, step_s); }
    self->placed = 1;
    if (is_running(self) && (self->cycles < UINT32_MAX)) { self->cycles++; }
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

void sd_afr_step(sd_afr_t *self, uint32_t cycle_position, float lambda) {
    if (self->placed == 0u) { return; }
    sd_exhaust_step_f32(&self->exhaust, cycle_position, &self->now);
    const float air = (lambda < 2.0f) ? 1.0f - lambda : SD_AFR_NO_SAMPLE;
    if (is_chain(self)) {
        sd_afr_chain_step_f32(&self->chain, &self->now, cycle_position, air);
    } else {
        sd_afr_joint_step(&self->joint, &self->now, air, NULL);
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

static float mean_of(const sd_afr_t *self) {
    float sum = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { sum += sd_afr_lambda(self, i); }
    sum /= (float)self->config.cylinders;
    return (sum > 0.02f) ? sum : 0.02f; /* in fuel cut there is no mixture to be off from */
}

float sd_afr_deviation(const sd_afr_t *self, uint32_t cylinder) {
    if (!is_running(self) || (cylinder >= self->config.cylinders)) { return 0.0f; }
    return sd_afr_lambda(self, cylinder) / mean_of(self) - 1.0f;
}

float sd_afr_deviation_sd(const sd_afr_t *self, uint32_t cylinder) {
    const float of = is_chain(self) ? sd_afr_chain_deviation_variance_f32(&self->chain) : sd_afr_joint_deviation_variance(&self->joint, cylinder);
    const float mean = mean_of(self), noise = of / (mean * mean);
    float square = 0.0f; /* an error of the model turns one cylinder's deviation into all the others' */
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        const float deviation = sd_afr_deviation(self, i);
        square += deviation * deviation / (float)self->config.cylinders;
    }
    const float variance = noise + self->doubt * square + 1e-12f;
    return sd_root(variance);
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
