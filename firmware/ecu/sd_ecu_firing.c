/* SPDX-License-Identifier: MIT */
/* The filter on tooth times in the ecu: its inputs, its signals, and when the tooth pattern is learned. */
#include "sd_ecu_parts.h"

#include <string.h>

#define RAD_PER_DEG 0.017453293f
#define INTAKE_USUAL_BAR 1.0f
#define INPUT_OLD_S 0.5f
#define ZERO_REVOLUTIONS 40u /* without fuel before a cylinder's zero is read: burnt gas is gone, the pattern known, the filter at rest */

static bool has_filter(const sd_ecu_t *self) {
    return (self->calibration.kalman.positions != 0u) && (self->calibration.parameters.firing_enabled > 0.5f);
}

/* A sensor that spoke lately. */
const sd_sample_t *sd_ecu_recent(const sd_ecu_t *self, sd_input_t input, uint32_t tick) {
    const sd_sample_t *sample = &self->sample[input];
    const bool old = (float)(uint32_t)(tick - sample->tick) > INPUT_OLD_S * self->calibration.tick_hz;
    return ((sample->seen == 0u) || old) ? NULL : sample;
}

static sd_kalman_tooth_t filter_tooth(const sd_ecu_t *self, const sd_tooth_t *tooth) {
    const float unlearned_rad = self->calibration.parameters.firing_pattern_deg * RAD_PER_DEG;
    const sd_pattern_t *pattern = &self->pattern;
    const bool learned = (pattern->sd_rad > 0.0f) && (pattern->sd_rad < unlearned_rad);
    const sd_sample_t *intake = sd_ecu_recent(self, SD_INPUT_AIR_INTAKE_PRESSURE, tooth->tick);
    return (sd_kalman_tooth_t){ .cycle_position = tooth->cycle_position,
                                .advance = tooth->advance,
                                .period_ticks = tooth->period_ticks,
                                .trusted = (tooth->health == SD_VALID) ? 1u : 0u,
                                .late_rad = learned ? pattern->late_rad[tooth->position] : 0.0f,
                                .pattern_rad = learned ? pattern->sd_rad : unlearned_rad,
                                .intake_bar = (intake != NULL) ? intake->value : INTAKE_USUAL_BAR };
}

/* Motored for so long that no cylinder of the cycle to come holds burnt gas. */
static bool is_motored(sd_ecu_t *self, const sd_tooth_t *tooth) {
    const sd_sample_t *fuel = sd_ecu_recent(self, SD_INPUT_FUEL_INJECTED, tooth->tick);
    const bool cut = (fuel != NULL) && (fuel->value <= 0.0f);
    const uint32_t since = (uint32_t)self->motored + tooth->advance;
    self->motored = (uint16_t)(!cut ? 0u : (since > UINT16_MAX) ? UINT16_MAX : since);
    return self->motored > 4u * self->calibration.positions;
}

/* At what frequencies the crank twists. */
static void take_twist(sd_ecu_t *self) {
    sd_twist_tune(&self->pattern.sums.twist, &self->filter);
    self->rough.tuning = self->filter.tuning;
}

static void learn(sd_ecu_t *self, const sd_tooth_t *tooth, const sd_kalman_tooth_t *seen) {
    const bool known = (self->crank.phase_votes >= 2u) && (sd_ecu_recent(self, SD_INPUT_AIR_INTAKE_PRESSURE, tooth->tick) != NULL);
    if (!is_motored(self, tooth) || !known) {
        sd_pattern_pause(&self->pattern);
    } else if (sd_pattern_step(&self->pattern, &self->calibration.kalman, seen)) {
        self->signals.wheel_learned_cycles = self->pattern.sums.cycles;
        self->signals.wheel_pattern_sd_deg = self->pattern.sd_rad / RAD_PER_DEG;
        take_twist(self);
    }
}

static void take_zeros(sd_ecu_t *self) {
    sd_pattern_zeros(&self->pattern, &self->calibration.kalman, self->filter.zero_nm_per_bar);
    memcpy(self->rough.zero_nm_per_bar, self->filter.zero_nm_per_bar, sizeof self->rough.zero_nm_per_bar);
}

/* What cylinders read without fuel is their zero. */
static void learn_zero(sd_ecu_t *self, const sd_firing_t *firing) {
    const bool rests = (self->motored > ZERO_REVOLUTIONS * self->calibration.positions) &&
                       sd_twist_known(&self->pattern.twist, &self->calibration.kalman);
    if (!rests || (self->status[SD_OWNER_FIRING].health != SD_VALID)) { return; }
    const float speed = self->signals.crank_speed_rpm * 0.10471976f;
    if (sd_pattern_take_zero(&self->pattern, &self->calibration.kalman, firing, self->filter.charge_bar[firing->index], speed)) {
        take_zeros(self);
    }
}

/* A tooth left out, or not sure, spoils the firings under way. */
static void watch_teeth(sd_ecu_t *self, const sd_tooth_t *tooth) {
    const bool bad = (tooth->health != SD_VALID) || (sd_ecu_filter(self)->rejected_in_row != 0u);
    self->firing_doubt = (self->firing_doubt > tooth->advance) ? (uint16_t)(self->firing_doubt - tooth->advance) : 0u;
    if (bad && (self->firing_doubt < self->calibration.positions)) { self->firing_doubt = self->calibration.positions; }
}

void sd_ecu_firing_spurious(sd_ecu_t *self) { self->firing_doubt = (uint16_t)(4u * self->calibration.positions); }

static void judge(sd_ecu_t *self, const sd_tooth_t *tooth) {
    sd_status_t *status = &self->status[SD_OWNER_FIRING];
    *status = sd_kalman_status(sd_ecu_filter(self), &self->calibration.kalman);
    if (self->crank.phase_votes < 2u) { sd_ecu_worst_of(status, SD_INVALID, SD_WHY_NO_PHASE); }
    if (self->firing_doubt > 0u) { sd_ecu_worst_of(status, SD_DEGRADED, SD_WHY_FAULT); }
    if (sd_ecu_recent(self, SD_INPUT_AIR_INTAKE_PRESSURE, tooth->tick) == NULL) {
        sd_ecu_worst_of(status, SD_DEGRADED, SD_WHY_NO_INPUT);
    }
}

void sd_ecu_firing_restart(sd_ecu_t *self) {
    if (!has_filter(self)) { return; }
    sd_kalman_restart(&self->filter);
    sd_kalman_restart(&self->rough);
    sd_road_restart(&self->road);
    sd_misfire_start(&self->misfire);
    sd_pattern_pause(&self->pattern);
    self->motored = 0;
    self->status[SD_OWNER_MISFIRE] = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_CONVERGING };
}

const sd_kalman_t *sd_ecu_filter(const sd_ecu_t *self) { return (self->on_rough != 0u) ? &self->rough : &self->filter; }

/* Both filters take the tooth. The road chooses between them, unless one of them had to begin anew. */
static bool step_filters(sd_ecu_t *self, const sd_kalman_tooth_t *seen, sd_firing_t *firing) {
    const sd_kalman_tables_t *tables = &self->calibration.kalman;
    const bool complete = sd_kalman_step(&self->filter, tables, seen, firing);
    if (tables->sets < 2u) { return complete; }
    sd_firing_t other;
    const bool other_complete = sd_kalman_step(&self->rough, tables, seen, &other);
    const uint8_t smooth = sd_kalman_status(&self->filter, tables).health, rough = sd_kalman_status(&self->rough, tables).health;
    const bool settled = (smooth == (uint8_t)SD_VALID) && (rough == (uint8_t)SD_VALID);
    if (!settled) {
        sd_road_restart(&self->road);
    } else if (complete && other_complete) {
        (void)sd_road_step(&self->road, firing, &other);
    }
    self->on_rough = (smooth != rough) ? (smooth > rough) : self->road.rough;
    /* The pulses' shape is learned by the one that is believed. */
    *((self->on_rough != 0u) ? &self->filter.shape : &self->rough.shape) = sd_ecu_filter(self)->shape;
    if (self->on_rough == 0u) { return complete; }
    *firing = other;
    return other_complete;
}

static void keep_for_trims(sd_cycle_firings_t *cycle, const sd_firing_t *firing, uint8_t health) {
    cycle->torque_nm[firing->index] = firing->torque_nm;
    cycle->sd_nm[firing->index] = firing->sd_nm;
    if (health > cycle->health) { cycle->health = health; }
    cycle->count++;
}

void sd_ecu_firing_tooth(sd_ecu_t *self, const sd_port_t *port, const sd_tooth_t *tooth) {
    if (!has_filter(self)) {
        self->status[SD_OWNER_FIRING] = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_UNCALIBRATED };
        self->status[SD_OWNER_MISFIRE] = self->status[SD_OWNER_FIRING];
        self->signals.firing_waveform_nm = 0.0f;
        return;
    }
    sd_ecu_misfire_tooth(self, tooth);
    const sd_kalman_tooth_t seen = filter_tooth(self, tooth);
    sd_firing_t firing;
    const bool complete = step_filters(self, &seen, &firing);
    self->signals.firing_waveform_nm = sd_ecu_filter(self)->torque_nm;
    watch_teeth(self, tooth);
    if ((self->filter.teeth == 0u) || (sd_ecu_filter(self)->teeth == 0u)) { sd_misfire_start(&self->misfire); } /* began anew */
    judge(self, tooth);
    learn(self, tooth, &seen);
    if (!complete) { return; }
    learn_zero(self, &firing);
    keep_for_trims(&self->cycle_firings, &firing, self->status[SD_OWNER_FIRING].health);
    self->signals.firing_cylinder = (float)self->calibration.firing_order[firing.index];
    self->signals.firing_torque_nm = firing.torque_nm;
    self->signals.firing_sd_nm = firing.sd_nm;
    self->signals.firing_mean_nm = firing.mean_nm;
    self->signals.firing_mean_sd_nm = firing.mean_sd_nm;
    self->signals.firing_rough = (float)self->on_rough;
    sd_ecu_misfire_firing(self, &firing, tooth->tick);
    sd_ecu_publish(self, port, tooth->tick, SD_RATE_FIRING);
}

sd_result_t sd_ecu_resume(sd_ecu_t *self, const sd_pattern_sums_t *learned) {
    if (!has_filter(self) || (sd_pattern_resume(&self->pattern, &self->calibration.kalman, learned) != SD_OK)) {
        return SD_ERR_CONFIG;
    }
    take_zeros(self);
    take_twist(self);
    self->signals.wheel_learned_cycles = self->pattern.sums.cycles;
    self->signals.wheel_pattern_sd_deg = self->pattern.sd_rad / RAD_PER_DEG;
    return SD_OK;
}
