/* SPDX-License-Identifier: MIT */
#include "sd_afr.h"

#include <string.h>

enum { SETTLE = 8, SETTLE_SLOW = 200 }; /* cycles */

#define START_LAMBDA 0.5f
#define REJECT_SD    8.0f
#define LAG_LEAD     1.5f /* positions by which the filter's lags lead: docs/afr.md */

sd_result_t sd_afr_init(sd_afr_t *self, const sd_afr_config_t *config, const sd_afr_grid_t *grid) {
    if ((grid->present == 0u) || !((config->drift > 0.0f) && (config->drift_slow > 0.0f) && (config->slow_above > 0.0f) && (config->jump >= 0.0f) && (config->jump <= 1.0f))) {
        return SD_ERR_CONFIG;
    }
    sd_exhaust_config_t exhaust = { .cycle_positions = config->cycle_positions, .cylinders = config->cylinders,
                                    .mass_base_kg = grid->mass_base_kg };
    memcpy(exhaust.firing_position, config->firing_position, sizeof exhaust.firing_position);
    memcpy(exhaust.psi, grid->psi, sizeof exhaust.psi);
    const sd_afr_joint_config_t joint = { .cylinders = config->cylinders, .tau1_s = grid->tau1_s, .tau2_s = grid->tau2_s,
                                          .noise_per_rthz = config->noise_per_rthz, .drift = config->drift * START_LAMBDA,
                                          .start_sd = 0.1f, .reject = REJECT_SD };
    sd_exhaust_f32_t fresh;
    if (sd_exhaust_init_f32(&fresh, &exhaust) != SD_OK) { return SD_ERR_CONFIG; }
    sd_afr_joint_t filter;
    if (sd_afr_joint_init(&filter, &joint) != SD_OK) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->config = *config;
    self->exhaust = fresh;
    self->joint = filter;
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

void sd_afr_cycle(sd_afr_t *self, const sd_afr_grid_t *grid, float speed_radps, float intake_bar, float fuel_mg) {
    if (!(speed_radps > 0.0f) || !(intake_bar > 0.0f) || !(fuel_mg >= 0.0f)) { return; }
    float sum = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { sum += sd_afr_joint_lambda(&self->joint, i); }
    if (self->joint.running != 0u) { self->mean_lambda = sum / (float)self->config.cylinders; }
    sd_afr_node_t node;
    interpolate(self, grid, speed_radps, intake_bar, &node);
    const float step_s = 12.566371f / (speed_radps * (float)self->config.cycle_positions);
    const float charge_kg = grid->air_kg_per_bar * intake_bar + 1e-6f * fuel_mg;
    const sd_exhaust_point_t point = { .share = self->share, .charge_kg = charge_kg, .rate_hz = node.rate_hz, .z0_kg = node.z0_kg,
                                       .pipe_kg = node.transport_kg, .delay_positions = (grid->dead_s + self->known.late_s) / step_s + LAG_LEAD };
    if (sd_exhaust_set_f32(&self->exhaust, &point, step_s) != SD_OK) { return; }
    self->joint.config.tau1_s = grid->tau1_s * (1.0f + self->known.lag);
    self->joint.config.tau2_s = grid->tau2_s * (1.0f + self->known.lag);
    self->doubt = sd_afr_delay_doubt(&self->known, speed_radps, self->joint.config.tau1_s, self->joint.config.tau2_s);
    const uint8_t slow = (speed_radps * (grid->tau1_s + grid->tau2_s) > self->config.slow_above) ? 1u : 0u;
    if (slow != self->slow) { self->cycles = 0; }
    self->slow = slow;
    const float lambda = (self->mean_lambda > 0.05f) ? self->mean_lambda : 0.05f;
    sd_afr_joint_set(&self->joint, step_s, lambda * ((slow != 0u) ? self->config.drift_slow : self->config.drift), lambda * self->config.jump);
    self->placed = 1;
    if ((self->joint.running != 0u) && (self->cycles < UINT32_MAX)) { self->cycles++; }
}

void sd_afr_correct(sd_afr_t *self, const sd_afr_learned_t *known) {
    const bool ok = (known->late_s >= -0.05f) && (known->late_s <= 0.05f) && (known->lag >= -0.5f) && (known->lag <= 0.5f) &&
                    (known->late_sd_s >= 0.0f) && (known->late_sd_s < 1.0f) && (known->lag_sd >= 0.0f) && (known->lag_sd < 10.0f);
    if (ok) { self->known = *known; }
}

void sd_afr_restart(sd_afr_t *self) {
    sd_afr_joint_restart(&self->joint);
    self->cycles = 0;
}

void sd_afr_step(sd_afr_t *self, uint32_t cycle_position, float lambda) {
    if (self->placed == 0u) { return; }
    sd_exhaust_step_f32(&self->exhaust, cycle_position, &self->now);
    sd_afr_joint_step(&self->joint, &self->now, (lambda < 2.0f) ? 1.0f - lambda : SD_AFR_NO_SAMPLE, NULL);
    if (self->joint.running == 0u) { self->cycles = 0; }
}

void sd_afr_trimmed(sd_afr_t *self, uint32_t cylinder, float fuel_factor) {
    sd_afr_joint_move(&self->joint, cylinder, (fuel_factor - 1.0f) * sd_afr_joint_lambda(&self->joint, cylinder));
}

float sd_afr_lambda(const sd_afr_t *self, uint32_t cylinder) { return sd_afr_joint_lambda(&self->joint, cylinder); }

static float mean_of(const sd_afr_t *self) {
    float sum = 0.0f;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { sum += sd_afr_joint_lambda(&self->joint, i); }
    sum /= (float)self->config.cylinders;
    return (sum > 0.02f) ? sum : 0.02f; /* in fuel cut there is no mixture to be off from */
}

float sd_afr_deviation(const sd_afr_t *self, uint32_t cylinder) {
    if ((self->joint.running == 0u) || (cylinder >= self->config.cylinders)) { return 0.0f; }
    return sd_afr_joint_lambda(&self->joint, cylinder) / mean_of(self) - 1.0f;
}

float sd_afr_deviation_sd(const sd_afr_t *self, uint32_t cylinder) {
    const float mean = mean_of(self), noise = sd_afr_joint_deviation_variance(&self->joint, cylinder) / (mean * mean);
    float square = 0.0f; /* an error of the model turns one cylinder's deviation into all the others' */
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        const float deviation = sd_afr_deviation(self, i);
        square += deviation * deviation / (float)self->config.cylinders;
    }
    const float variance = noise + self->doubt * square + 1e-12f;
    return variance * sd_rsqrt_f32(variance);
}

sd_status_t sd_afr_status(const sd_afr_t *self) {
    sd_status_t status = sd_afr_joint_status(&self->joint);
    if ((status.health == SD_VALID) && (self->cycles < ((self->slow != 0u) ? SETTLE_SLOW : SETTLE))) {
        status.health = SD_DEGRADED;
        status.why |= SD_WHY_CONVERGING;
    }
    return status;
}
