/* SPDX-License-Identifier: MIT */
#include "sd_stage_misfire.h"

#include <string.h>

/* ---- choices --------------------------------------------------------------------------------------------------------- */

static sd_wheel_config_q31_t to_q31(const sd_wheel_config_f32_t *c) {
    return (sd_wheel_config_q31_t){ .definition = sd_from_float_q31(c->definition),
                                    .work_min = sd_from_float_q31(c->work_min),
                                    .speed_change = sd_from_float_q31(c->speed_change),
                                    .start_firings = c->start_firings,
                                    .hold_firings = c->hold_firings,
                                    .kind = c->kind };
}

static sd_result_t start_wheel(sd_stage_misfire_t *self, const sd_wheel_tables_t *tables, const sd_wheel_config_f32_t *config, bool fixed) {
    const sd_wheel_config_q31_t in_q31 = to_q31(config);
    return fixed ? sd_wheel_init_q31(&self->wheel.q31, &in_q31, tables) : sd_wheel_init_f32(&self->wheel.f32, config, tables);
}

/* An observer starts anew only where it is another one; without tables it refuses, and nothing is changed. */
static sd_result_t choose(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const uint8_t method = (uint8_t)p->misfire_method, fixed = (p->misfire_arithmetic > 0.5f) ? 1u : 0u;
    if (method != (uint8_t)SD_METHOD_MONITOR) {
        const sd_wheel_config_f32_t config = sd_calibration_wheel(page, p, (sd_wheel_kind_t)(method - 1u));
        const sd_wheel_config_q31_t in_q31 = to_q31(&config);
        const bool same = (method == self->method) && (fixed == self->fixed_point);
        const sd_result_t result = !same            ? start_wheel(self, &page->wheel, &config, fixed != 0u)
                                   : (fixed != 0u) ? sd_wheel_configure_q31(&self->wheel.q31, &in_q31)
                                                   : sd_wheel_configure_f32(&self->wheel.f32, &config);
        if (result != SD_OK) { return result; }
    }
    self->method = method;
    self->fixed_point = fixed;
    self->work_per_mg = sd_calibration_work(page, p);
    self->converted_mg = SD_FUEL_UNKNOWN;
    self->work = -1;
    self->fuel_level_min_percent = p->misfire_fuel_level_min_percent;
    return SD_OK;
}

sd_result_t sd_stage_misfire_init(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_misfire_config_t config = sd_calibration_misfire(page, p);
    self->method = (uint8_t)SD_METHOD_MONITOR;
    if ((choose(self, page, p) != SD_OK) || (sd_misfire_init(&self->monitor, &config) != SD_OK)) { return SD_ERR_CONFIG; }
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) { self->fuel_mg[i] = SD_FUEL_UNKNOWN; }
    return SD_OK;
}

sd_result_t sd_stage_misfire_configure(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_misfire_config_t config = sd_calibration_misfire(page, p);
    const sd_result_t result = sd_misfire_configure(&self->monitor, &config);
    return (result == SD_OK) ? choose(self, page, p) : result; /* refuses the method alone, of which the monitor knows nothing */
}

void sd_stage_misfire_restart(sd_stage_misfire_t *self) {
    sd_misfire_start(&self->monitor);
    self->status = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_CONVERGING };
    if (!sd_stage_misfire_observes(self)) { return; }
    if (self->fixed_point != 0u) { sd_wheel_restart_q31(&self->wheel.q31); } else { sd_wheel_restart_f32(&self->wheel.f32); }
}

void sd_stage_misfire_spurious(sd_stage_misfire_t *self, const sd_calibration_t *page) { self->doubt = (uint16_t)(2u * page->positions); }

/* ---- a tooth --------------------------------------------------------------------------------------------------------- */

static uint32_t step_wheel(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg) {
    const sd_wheel_tooth_t seen = { .cycle_position = tooth->cycle_position,
                                    .advance = tooth->advance,
                                    .period_ticks = tooth->period_ticks,
                                    .trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u };
    if (seen.trusted == 0u) { self->doubt = page->positions; }
    self->doubt = (self->doubt > seen.advance) ? (uint16_t)(self->doubt - seen.advance) : 0u;
    if (self->fixed_point == 0u) { return sd_wheel_tooth_f32(&self->wheel.f32, &page->wheel, &seen, fuel_mg * self->work_per_mg); }
    if (fuel_mg != self->converted_mg) {
        self->converted_mg = fuel_mg;
        self->work = (fuel_mg >= 0.0f) ? sd_from_float_q31(fuel_mg * self->work_per_mg) : -1;
    }
    return sd_wheel_tooth_q31(&self->wheel.q31, &page->wheel, &seen, self->work);
}

/* Between two TDCs no fuel is looked up. */
static void note_fuel(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg) {
    const uint32_t cycle = 2u * page->positions, at = (uint32_t)self->position + tooth->advance;
    const bool follows = tooth->cycle_position == ((at >= cycle) ? at - cycle : at);
    self->position = tooth->cycle_position;
    if (follows && (tooth->advance < self->until_tdc)) {
        self->until_tdc = (uint16_t)(self->until_tdc - tooth->advance);
        return;
    }
    uint32_t until = cycle;
    for (uint32_t i = 0; i < page->cylinders; ++i) {
        const uint32_t tdc = page->firing_position[i];
        const uint32_t since = (tooth->cycle_position >= tdc) ? tooth->cycle_position - tdc : tooth->cycle_position + cycle - tdc;
        if (since < tooth->advance) { self->fuel_mg[i] = fuel_mg; }
        if (cycle - since < until) { until = cycle - since; }
    }
    self->until_tdc = (uint16_t)until;
}

uint32_t sd_stage_misfire_tooth(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg) {
    note_fuel(self, page, tooth, fuel_mg);
    return sd_stage_misfire_observes(self) ? step_wheel(self, page, tooth, fuel_mg) : 0u;
}

/* ---- a firing -------------------------------------------------------------------------------------------------------- */

/* What the outside forbids to judge, whoever judges. */
static uint32_t inhibits(const sd_stage_misfire_t *self, const sd_stage_misfire_in_t *in) {
    uint32_t why = 0;
    if (in->shifting) { why |= (uint32_t)SD_INHIBIT_SHIFT; }
    if (in->level_known && (in->fuel_level_percent < self->fuel_level_min_percent)) { why |= (uint32_t)SD_INHIBIT_LEVEL; }
    return why;
}

static sd_misfire_verdict_t ask_monitor(sd_stage_misfire_t *self, const sd_stage_misfire_in_t *in) {
    const uint32_t spoilt = (uint32_t)SD_WHY_FAULT | (uint32_t)SD_WHY_REJECTED;
    uint32_t why = inhibits(self, in);
    if ((in->estimate.why & (uint32_t)SD_WHY_CONVERGING) != 0u) { why |= (uint32_t)SD_INHIBIT_ESTIMATE; }
    if ((self->fuel_mg[in->firing] < 0.0f) || ((in->estimate.why & spoilt) != 0u)) { why |= (uint32_t)SD_INHIBIT_OUTSIDE; }
    const sd_misfire_firing_t seen = { .index = (uint8_t)in->firing,
                                       .health = in->estimate.health,
                                       .geared = in->geared ? 1u : 0u,
                                       .inhibit = (uint8_t)why,
                                       .torque_nm = in->read->torque_nm,
                                       .torque_sd_nm = in->read->sd_nm,
                                       .fuel_mg = self->fuel_mg[in->firing],
                                       .speed_radps = in->speed_radps,
                                       .energy_j = in->energy_j };
    return sd_misfire_assess(&self->monitor, &seen);
}

/* The wheel's verdict in the units of everybody. */
static void ask_wheel(sd_stage_misfire_t *self, const sd_calibration_t *page, uint32_t firing, uint32_t why, sd_stage_misfire_out_t *out) {
    const float accel_base = (float)(1u << (uint32_t)page->wheel.accel_exponent), index_base = (float)(1u << SD_WHEEL_INDEX_BITS);
    sd_wheel_verdict_f32_t v;
    if (self->fixed_point != 0u) {
        sd_wheel_verdict_q31_t q31;
        sd_wheel_judge_q31(&self->wheel.q31, &page->wheel, firing, why, &q31);
        v = (sd_wheel_verdict_f32_t){ .accel = sd_to_float_q31(q31.accel), .residual = sd_to_float_q31(q31.residual),
                                      .index = sd_to_float_q31(q31.index), .verdict = q31.verdict, .inhibit = q31.inhibit };
    } else {
        sd_wheel_judge_f32(&self->wheel.f32, &page->wheel, firing, why, &v);
    }
    const bool judged = v.inhibit == 0u;
    const float definition = (self->fixed_point != 0u) ? sd_to_float_q31(self->wheel.q31.config.definition)
                                                       : self->wheel.f32.config.definition;
    out->verdict = (sd_misfire_verdict_t){ .verdict = v.verdict, .inhibit = v.inhibit, .firing = (uint8_t)firing,
                                           .cylinder = page->firing_order[firing], .index = v.index * index_base,
                                           .limit = judged ? definition : 0.0f };
    out->accel_radps2 = v.accel * accel_base;
    out->residual_radps2 = v.residual * accel_base;
}

static sd_status_t status_of(const sd_stage_misfire_t *self, const sd_misfire_verdict_t *v) {
    const uint32_t begins = (uint32_t)SD_INHIBIT_START | (uint32_t)SD_INHIBIT_ESTIMATE;
    const uint16_t rejected = (self->fixed_point != 0u) ? self->wheel.q31.rejected : self->wheel.f32.rejected;
    sd_status_t status = { .health = SD_VALID, .rejected = rejected };
    if (v->inhibit == 0u) { return status; }
    status.health = SD_INVALID;
    status.why = ((v->inhibit & begins) != 0u) ? (uint16_t)SD_WHY_CONVERGING : (uint16_t)SD_WHY_REJECTED;
    return status;
}

void sd_stage_misfire_firing(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_stage_misfire_in_t *in,
                             sd_stage_misfire_out_t *out) {
    memset(out, 0, sizeof *out);
    out->verdict.verdict = out->monitor = (uint8_t)SD_NOT_JUDGED;
    if (in->firing >= page->cylinders) { return; }
    if (in->read != NULL) {
        out->verdict = ask_monitor(self, in);
        out->monitor = out->verdict.verdict;
        self->status = sd_misfire_status(&self->monitor);
        sd_status_worst_of(&self->status, in->estimate.health, in->estimate.why);
    }
    if (sd_stage_misfire_observes(self)) {
        uint32_t why = inhibits(self, in);
        if (self->doubt != 0u) { why |= (uint32_t)SD_INHIBIT_OUTSIDE; }
        if (!in->phase_known) { why |= (uint32_t)SD_INHIBIT_ESTIMATE; }
        ask_wheel(self, page, in->firing, why, out);
        self->status = status_of(self, &out->verdict);
    }
    sd_misfire_count(&self->monitor, &out->verdict);
}
