/* SPDX-License-Identifier: MIT */
/* The misfire monitor in the ecu: what each firing was given, and what came of it. */
#include "sd_ecu_parts.h"

/* The command at its TDC is what a firing is judged by: it is read 300 deg later, when the command may have changed. */
void sd_ecu_misfire_tooth(sd_ecu_t *self, const sd_tooth_t *tooth) {
    const sd_calibration_t *c = &self->calibration;
    const uint32_t cycle = 2u * c->positions;
    const sd_sample_t *fuel = sd_ecu_recent(self, SD_INPUT_FUEL_INJECTED, tooth->tick);
    for (uint32_t i = 0; i < c->cylinders; ++i) {
        const uint32_t since = (tooth->cycle_position + cycle - c->firing_position[i]) % cycle;
        if (since < tooth->advance) { self->fuel_mg[i] = (fuel != NULL) ? fuel->value : -1.0f; }
    }
}

/* What forbids to judge the firing just read, beyond what the monitor sees itself. */
static uint8_t inhibits(const sd_ecu_t *self, uint32_t tick, float fuel_mg) {
    const uint16_t spoilt = (uint16_t)(SD_WHY_FAULT | SD_WHY_REJECTED);
    const sd_sample_t *shift = sd_ecu_recent(self, SD_INPUT_DRIVELINE_SHIFT, tick);
    const sd_sample_t *level = &self->sample[SD_INPUT_FUEL_LEVEL];
    uint32_t why = 0;
    if ((self->status[SD_OWNER_FIRING].why & (uint16_t)SD_WHY_CONVERGING) != 0u) { why |= SD_INHIBIT_ESTIMATE; }
    if ((fuel_mg < 0.0f) || ((self->status[SD_OWNER_FIRING].why & spoilt) != 0u)) { why |= SD_INHIBIT_OUTSIDE; }
    if ((shift != NULL) && (shift->value > 0.5f)) { why |= SD_INHIBIT_SHIFT; }
    if ((level->seen != 0u) && (level->value < self->calibration.parameters.misfire_fuel_level_min_percent)) { why |= SD_INHIBIT_LEVEL; }
    return (uint8_t)why;
}

static void show(sd_ecu_t *self, const sd_misfire_verdict_t *v) {
    sd_signals_t *s = &self->signals;
    s->misfire_index = v->index;
    s->misfire_limit = v->limit;
    s->misfire_verdict = (float)v->verdict;
    s->misfire_inhibit = (float)v->inhibit;
    s->misfire_firing = (float)v->firing;
    s->misfire_cylinder = (float)v->cylinder;
}

static void report(sd_ecu_t *self) {
    sd_signals_t *s = &self->signals;
    sd_misfire_report_t r;
    sd_misfire_read(&self->misfire, &r);
    for (uint32_t i = 0; i < self->calibration.cylinders; ++i) {
        const uint32_t cylinder = self->calibration.firing_order[i] - 1u;
        s->misfire_rate_200_percent[cylinder] = r.percent_200[cylinder];
        s->misfire_rate_1000_percent[cylinder] = r.percent_1000[cylinder];
    }
    s->misfire_continuous = (float)r.continuous;
    s->misfire_suspects = (float)r.suspects;
    s->misfire_lamp = (float)r.lamp;
    s->misfire_count = (float)r.misfires;
    s->misfire_partial_burns = (float)r.partial_burns;
    self->status[SD_OWNER_MISFIRE] = r.status;
}

void sd_ecu_misfire_firing(sd_ecu_t *self, const sd_firings_out_t *out, uint32_t tick) {
    const sd_firing_t *firing = &out->firing;
    const sd_status_t *estimate = &self->status[SD_OWNER_FIRING];
    const float fuel_mg = self->fuel_mg[firing->index];
    const sd_misfire_firing_t seen = {
        .index = firing->index,
        .health = estimate->health,
        .inhibit = inhibits(self, tick, fuel_mg),
        .torque_nm = firing->torque_nm,
        .torque_sd_nm = firing->sd_nm,
        .fuel_mg = fuel_mg,
        .speed_radps = out->speed_radps,
        .energy_j = out->energy_j,
    };
    const sd_misfire_verdict_t verdict = sd_misfire_judge(&self->misfire, &seen);
    if (verdict.verdict == (uint8_t)SD_MISFIRE) { self->cycle_firings.misfired = 1; }
    show(self, &verdict);
    report(self);
    sd_ecu_worst_of(&self->status[SD_OWNER_MISFIRE], estimate->health, estimate->why);
}
