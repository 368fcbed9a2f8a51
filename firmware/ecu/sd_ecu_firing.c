/* SPDX-License-Identifier: MIT */
/* Torque of single firings in the ecu: what the block takes, and where what it says goes. */
#include "sd_ecu_parts.h"

#define RAD_PER_DEG 0.017453293f
#define RADPS_PER_RPM 0.10471976f
#define INTAKE_USUAL_BAR 1.0f
#define INPUT_OLD_S 0.5f

/* A sensor that spoke lately. */
const sd_sample_t *sd_ecu_recent(const sd_ecu_t *self, sd_input_t input, uint32_t tick) {
    const sd_sample_t *sample = &self->sample[input];
    const bool old = (float)(uint32_t)(tick - sample->tick) > INPUT_OLD_S * self->calibration.tick_hz;
    return ((sample->seen == 0u) || old) ? NULL : sample;
}

sd_firings_config_t sd_ecu_firings_config(const sd_calibration_t *c) {
    const sd_parameters_t *p = &c->parameters;
    return (sd_firings_config_t){ .torque_base_nm = p->torque_torque_base_nm,
                                  .reject_deg = p->firing_reject_deg,
                                  .settle_cycles = p->firing_settle_cycles,
                                  .pattern_deg = p->firing_pattern_deg,
                                  .teeth = (uint8_t)(c->positions - c->missing_count),
                                  .enabled = (p->firing_enabled > 0.5f) ? 1u : 0u };
}

void sd_ecu_firing_spurious(sd_ecu_t *self) { sd_firings_spurious(&self->firings, &self->calibration.kalman); }

void sd_ecu_firing_restart(sd_ecu_t *self) {
    if (self->firings.enabled == 0u) { return; }
    sd_firings_restart(&self->firings);
    sd_misfire_start(&self->misfire);
    self->status[SD_OWNER_MISFIRE] = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_CONVERGING };
}

static sd_firings_tooth_t block_tooth(const sd_ecu_t *self, const sd_tooth_t *tooth) {
    const sd_sample_t *intake = sd_ecu_recent(self, SD_INPUT_AIR_INTAKE_PRESSURE, tooth->tick);
    const sd_sample_t *fuel = sd_ecu_recent(self, SD_INPUT_FUEL_INJECTED, tooth->tick);
    return (sd_firings_tooth_t){ .cycle_position = tooth->cycle_position,
                                 .position = tooth->position,
                                 .advance = tooth->advance,
                                 .period_ticks = tooth->period_ticks,
                                 .health = tooth->health,
                                 .phase_known = (self->crank.phase_votes >= 2u) ? 1u : 0u,
                                 .intake_known = (intake != NULL) ? 1u : 0u,
                                 .fuel_cut = ((fuel != NULL) && (fuel->value <= 0.0f)) ? 1u : 0u,
                                 .intake_bar = (intake != NULL) ? intake->value : INTAKE_USUAL_BAR,
                                 .speed_radps = self->signals.crank_speed_rpm * RADPS_PER_RPM };
}

static void keep_for_trims(sd_cycle_firings_t *cycle, const sd_firing_t *firing, uint8_t health) {
    cycle->torque_nm[firing->index] = firing->torque_nm;
    cycle->sd_nm[firing->index] = firing->sd_nm;
    if (health > cycle->health) { cycle->health = health; }
    cycle->count++;
}

static void show_learned(sd_ecu_t *self) {
    self->signals.wheel_learned_cycles = self->firings.pattern.sums.cycles;
    self->signals.wheel_pattern_sd_deg = self->firings.pattern.sd_rad / RAD_PER_DEG;
}

static void show_firing(sd_ecu_t *self, const sd_firings_out_t *out) {
    const sd_firing_t *firing = &out->firing;
    sd_signals_t *s = &self->signals;
    s->firing_cylinder = (float)self->calibration.firing_order[firing->index];
    s->firing_torque_nm = firing->torque_nm;
    s->firing_sd_nm = firing->sd_nm;
    s->firing_mean_nm = firing->mean_nm;
    s->firing_mean_sd_nm = firing->mean_sd_nm;
    s->firing_rough = (float)out->rough;
}

void sd_ecu_firing_tooth(sd_ecu_t *self, const sd_port_t *port, const sd_tooth_t *tooth) {
    const sd_firings_tooth_t seen = block_tooth(self, tooth);
    sd_firings_out_t out;
    sd_firings_step(&self->firings, &self->calibration.kalman, &seen, &out);
    self->status[SD_OWNER_FIRING] = out.status;
    self->signals.firing_waveform_nm = out.waveform_nm;
    if (self->firings.enabled == 0u) {
        self->status[SD_OWNER_MISFIRE] = out.status;
        return;
    }
    sd_ecu_misfire_tooth(self, tooth);
    if (out.restarted != 0u) { sd_misfire_start(&self->misfire); }
    if (out.learned != 0u) { show_learned(self); }
    if (out.complete == 0u) { return; }
    keep_for_trims(&self->cycle_firings, &out.firing, out.status.health);
    show_firing(self, &out);
    sd_ecu_misfire_firing(self, &out, tooth->tick);
    sd_ecu_publish(self, port, tooth->tick, SD_RATE_FIRING);
}

sd_result_t sd_ecu_resume(sd_ecu_t *self, const sd_pattern_sums_t *learned) {
    if (sd_firings_resume(&self->firings, &self->calibration.kalman, learned) != SD_OK) { return SD_ERR_CONFIG; }
    show_learned(self);
    return SD_OK;
}
