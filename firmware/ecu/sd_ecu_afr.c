/* SPDX-License-Identifier: MIT */
#include "sd_ecu_afr.h"

#include <string.h>

#include "sd_math.h"

#define TRANSIENT_SPEED 0.02f /* share by which a cycle may differ from the last and still be steady */
#define TRANSIENT_FUEL  0.05f
#define TORQUE_FOLLOWS  0.5f   /* a cycle: half of the firings that a cycle reads were injected before it began */
#define FOLLOW_LEAST    0.001f
#define CHAIN_FOLLOWS   0.3f   /* a cycle: it settles to a tenth in some 4 */

_Static_assert((SD_AFR_CYLINDERS_MAX == SD_CYLINDERS_MAX) && (SD_BALANCE_CYLINDERS_MAX == SD_CYLINDERS_MAX) &&
               (SD_MISFIRE_CYLINDERS_MAX == SD_CYLINDERS_MAX) && (SD_KALMAN_FIRINGS_MAX == SD_CYLINDERS_MAX),
               "blocks that hold the same engine hold as many cylinders");

static bool ready(const sd_ecu_t *self) { return self->afr.config.cylinders != 0u; }

/* The filter is told of the trims. The chain is not: its inverted sensor finds a trim some cycles later, and until then its
 * observer would take back what it was told. */
static bool is_told(const sd_ecu_t *self) { return self->afr.config.method == SD_AFR_JOINT; }

sd_result_t sd_ecu_afr_init(sd_afr_t *afr, const sd_calibration_t *c) {
    const sd_parameters_t *p = &c->parameters;
    if (c->afr.present == 0u) {
        memset(afr, 0, sizeof *afr);
        return SD_OK;
    }
    sd_afr_config_t config = { .method = (uint8_t)(p->afr_method + 0.5f), .gain_air = p->afr_gain_air, .gain_cylinder = p->afr_gain_cylinder,
                               .inversion_gain = p->afr_inversion_gain, .inversion_floor = p->afr_inversion_floor, .cycle_positions = (uint16_t)(2u * c->positions), .cylinders = c->cylinders,
                               .noise_per_rthz = p->afr_noise, .drift = p->afr_drift, .drift_slow = p->afr_drift_slow,
                               .jump = p->afr_jump, .slow_above = p->afr_slow_above };
    for (uint32_t i = 0; i < c->cylinders; ++i) { config.firing_position[i] = c->firing_position[i]; }
    return sd_afr_init(afr, &config, &c->afr, c->fourier.sine_q31);
}

sd_balance_config_t sd_ecu_balance_config(const sd_calibration_t *c) {
    const sd_parameters_t *p = &c->parameters;
    return (sd_balance_config_t){ .cylinders = c->cylinders, .gain = p->balance_gain,
                                  .rate = p->balance_rate, .limit = p->balance_limit, .sd_max = p->balance_sd_max,
                                  .hold_cycles = (uint16_t)p->balance_hold_cycles };
}

sd_result_t sd_ecu_balance_init(sd_balance_t *balance, const sd_calibration_t *c) {
    const sd_balance_config_t config = sd_ecu_balance_config(c);
    memset(balance, 0, sizeof *balance);
    /* One cylinder has nothing to be balanced with. */
    return (config.cylinders < 2u) ? SD_OK : sd_balance_init(balance, &config);
}

void sd_ecu_afr_restart(sd_ecu_t *self) {
    sd_afr_restart(&self->afr);
    sd_afr_delay_restart(&self->afr_delay);
}

void sd_ecu_afr_sample(sd_ecu_t *self, float lambda) {
    const float s = self->calibration.parameters.afr_stoichiometric;
    self->burned_sum += (1.0f + s) / (1.0f + s * lambda);
    self->burned_count++;
    self->burned_seen++;
}

static void step(sd_ecu_t *self, uint32_t cycle_position, float lambda) {
    sd_afr_step(&self->afr, cycle_position, lambda);
    sd_afr_delay_step(&self->afr_delay, &self->afr.now, cycle_position, 1.0f - lambda); /* no sample is none there either */
}

void sd_ecu_afr_tooth(sd_ecu_t *self, const sd_tooth_t *tooth) {
    if (ready(self)) {
        const uint32_t cycle = self->afr.config.cycle_positions;
        for (uint32_t back = tooth->advance; back-- > 1u;) {
            step(self, (tooth->cycle_position + cycle - back) % cycle, SD_AFR_NO_SAMPLE);
        }
        /* Across a mark the mean belongs to no one position. */
        const bool sampled = (self->burned_count > 0u) && (tooth->advance == 1u);
        step(self, tooth->cycle_position, sampled ? self->burned_sum / (float)self->burned_count : SD_AFR_NO_SAMPLE);
    }
    self->burned_sum = 0.0f;
    self->burned_count = 0;
}

static float changed(float now, float before) {
    const float step = (now > before) ? now - before : before - now;
    return (before > 0.0f) ? step / before : 1.0f;
}

static void say(sd_status_t *status, uint8_t health, uint16_t why) {
    if (health > status->health) { status->health = health; }
    status->why |= why;
}

static void read_afr(sd_ecu_t *self, float speed_radps) {
    const sd_calibration_t *c = &self->calibration;
    const sd_sample_t *intake = &self->sample[SD_INPUT_AIR_INTAKE_PRESSURE], *fuel = &self->sample[SD_INPUT_FUEL_INJECTED];
    sd_status_t *status = &self->status[SD_OWNER_AFR];
    if (!ready(self)) {
        *status = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_UNCALIBRATED };
        return;
    }
    sd_afr_cycle(&self->afr, &c->afr, speed_radps, intake->value, fuel->value);
    *status = sd_afr_status(&self->afr);
    if (self->crank.phase_votes < 2u) { say(status, SD_INVALID, SD_WHY_NO_PHASE); }
    if ((intake->seen == 0u) || (fuel->seen == 0u) || (self->burned_seen == 0u)) { say(status, SD_INVALID, SD_WHY_NO_INPUT); }
    self->burned_seen = 0;
    self->signals.afr_slow = (float)self->afr.slow;
    for (uint32_t i = 0; i < c->cylinders; ++i) {
        self->signals.afr_cylinder_burned[c->firing_order[i] - 1u] = sd_afr_lambda(&self->afr, i);
        self->signals.afr_cylinder_sd[c->firing_order[i] - 1u] = sd_afr_deviation_sd(&self->afr, i);
    }
}

/* What cylinders deviate by, in firing order, from the source chosen; returns the health of it. */
static uint8_t torque_deviations(const sd_ecu_t *self, float *deviation, float *sd) {
    const sd_cycle_firings_t *firings = &self->cycle_firings;
    const uint32_t n = self->calibration.cylinders;
    float mean = 0.0f;
    for (uint32_t i = 0; i < n; ++i) { mean += firings->torque_nm[i] / (float)n; }
    if ((firings->count < n) || !(mean > 1.0f)) { return SD_INVALID; } /* Nm: nothing burns */
    for (uint32_t i = 0; i < n; ++i) {
        deviation[i] = firings->torque_nm[i] / mean - 1.0f;
        sd[i] = firings->sd_nm[i] / mean;
    }
    return firings->health;
}

static uint8_t mixture_deviations(const sd_ecu_t *self, float *deviation, float *sd) {
    for (uint32_t i = 0; i < self->calibration.cylinders; ++i) {
        deviation[i] = sd_afr_deviation(&self->afr, i);
        sd[i] = sd_afr_deviation_sd(&self->afr, i);
    }
    return self->status[SD_OWNER_AFR].health;
}

/* Share of a change that the mixture's estimate takes up in a cycle: from its variance before and after, and its drift. */
static float mixture_follows(sd_ecu_t *self, float sd) {
    if (!is_told(self)) { return CHAIN_FOLLOWS; }
    const sd_parameters_t *p = &self->calibration.parameters;
    const float drift = (self->afr.slow != 0u) ? p->afr_drift_slow : p->afr_drift;
    const float before = self->last_variance + drift * drift;
    self->last_variance = sd * sd;
    const float follow = 1.0f - sd * sd / before;
    return (follow > 1.0f) ? 1.0f : (follow > FOLLOW_LEAST) ? follow : FOLLOW_LEAST;
}

static void balance(sd_ecu_t *self, uint8_t transient) {
    const sd_calibration_t *c = &self->calibration;
    sd_balance_t *b = &self->balance;
    const bool on = (self->sample[SD_INPUT_BALANCE_ENABLE].value > 0.5f) && (c->parameters.balance_source > 0.5f) && (c->cylinders > 1u);
    if (on) {
        const bool from_torque = c->parameters.balance_source > 1.5f;
        float deviation[SD_CYLINDERS_MAX] = { 0.0f }, sd[SD_CYLINDERS_MAX] = { 0.0f };
        sd_balance_input_t in = { .deviation = deviation, .sd = sd, .follow = TORQUE_FOLLOWS, .told = (uint8_t)((from_torque || !is_told(self)) ? 0 : 1), .transient = transient };
        in.health = from_torque ? torque_deviations(self, deviation, sd) : mixture_deviations(self, deviation, sd);
        if (!from_torque) { in.follow = mixture_follows(self, sd[0]); }
        sd_balance_step(b, &in);
    } else {
        sd_balance_restart(b);
    }
    self->status[SD_OWNER_BALANCE] = sd_balance_status(b);
}

/* The probe's trim comes on top of the balance's, within the same limit. */
static void command_trims(sd_ecu_t *self) {
    const sd_calibration_t *c = &self->calibration;
    const float limit = c->parameters.balance_limit, size = c->parameters.afr_probe;
    for (uint32_t i = 0; i < self->balance.config.cylinders; ++i) {
        const float trim = self->balance.trim[i] + size * sd_afr_delay_probe_trim(&self->afr_delay, i);
        self->fuel_trim[i] = (trim > limit) ? limit : (trim < -limit) ? -limit : trim;
        self->signals.balance_trim[c->firing_order[i] - 1u] = self->fuel_trim[i];
    }
}

/* Trims of a cycle ago reach the sensor about now: the filter need not find out what is known. */
static void tell_trims(sd_ecu_t *self) {
    for (uint32_t i = 0; i < self->balance.config.cylinders; ++i) {
        const float trim = self->fuel_trim[i];
        if (ready(self) && is_told(self)) { sd_afr_trimmed(&self->afr, i, (1.0f + trim) / (1.0f + self->last_trim[i])); }
        self->last_trim[i] = trim;
    }
}

void sd_ecu_afr_cycle(sd_ecu_t *self) {
    const float speed = self->signals.cycle_speed_rpm * SD_RADPS_PER_RPM, fuel = self->sample[SD_INPUT_FUEL_INJECTED].value;
    const bool moves = (changed(speed, self->last_speed_radps) > TRANSIENT_SPEED) || (changed(fuel, self->last_fuel_mg) > TRANSIENT_FUEL);
    tell_trims(self);
    /* What has not burned is no mixture to be trimmed, or to be learned from. */
    const bool usable = !moves && (fuel > 0.0f) && (self->cycle_firings.misfired == 0u);
    if (ready(self)) { sd_ecu_delay_cycle(self, speed, !usable); }
    read_afr(self, speed);
    balance(self, (!usable || (self->afr_delay.probed != 0u)) ? 1u : 0u);
    command_trims(self);
    self->cycle_firings.count = self->cycle_firings.health = self->cycle_firings.misfired = 0;
    self->last_speed_radps = speed;
    self->last_fuel_mg = fuel;
}
