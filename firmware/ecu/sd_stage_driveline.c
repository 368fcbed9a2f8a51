/* SPDX-License-Identifier: MIT */
#include "sd_stage_driveline.h"

static sd_driveline_damping_config_t damping_of(const sd_parameters_t *p) {
    return (sd_driveline_damping_config_t){ .gain_nms = p->driveline_damping_gain_nmsprad,
                                            .limit_nm = p->driveline_damping_limit_nm,
                                            .rate_nmps = p->driveline_damping_rate_nmps,
                                            .drop_nmps = p->driveline_damping_drop_nmps,
                                            .enabled = (p->driveline_damping > 0.5f) ? 1u : 0u };
}

sd_result_t sd_stage_driveline_init(sd_stage_driveline_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_page_driveline_t *driveline = sd_calibration_driveline(page);
    *self = (sd_stage_driveline_t){ .hybrid_gear = 0 };
    self->out.status = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_UNCALIBRATED };
    self->reference.status = self->out.status;
    self->choice = damping_of(p);
    if (sd_driveline_damping_init(&self->damping, &self->choice) != SD_OK) { return SD_ERR_CONFIG; }
    if (driveline == NULL) { return SD_OK; }
    if (!sd_page_driveline_ok(driveline) ||
        (sd_driveline_guard_init_f32(&self->guard, &driveline->tables) != SD_OK)) { return SD_ERR_CONFIG; }
    self->out.status.why = self->reference.status.why = SD_WHY_NO_SYNC;
    return SD_OK;
}

sd_result_t sd_stage_driveline_configure(sd_stage_driveline_t *self, const sd_parameters_t *p) {
    const sd_driveline_damping_config_t choice = damping_of(p);
    const float request_nm = self->damping.request_nm;
    if (sd_driveline_damping_init(&self->damping, &choice) != SD_OK) { return SD_ERR_CONFIG; }
    self->damping.request_nm = request_nm; /* a change of the gain is no reason for a jerk */
    self->choice = choice;
    return SD_OK;
}

static void rest(sd_stage_driveline_t *self, uint16_t why) {
    self->hybrid_gear = 0;
    self->reference = (sd_driveline_hybrid_out_t){ .location = 0 };
    self->reference.status = (sd_status_t){ .health = SD_INVALID, .why = why };
}

void sd_stage_driveline_restart(sd_stage_driveline_t *self, uint16_t why) {
    sd_driveline_guard_restart_f32(&self->guard);
    self->out = (sd_driveline_out_f32_t){ .location = 0 };
    self->out.status = (sd_status_t){ .health = SD_INVALID, .why = why, .rejected = self->guard.rejected };
    self->damping.request_nm = self->task_s = self->torque_nms = 0.0f;
    rest(self, why);
}

/* ---- on the tooth -------------------------------------------------------------------------------------------------- */

#define MEAN_TEETH 64.0f /* about a revolution */

/* The torque that a shaft which begins to be watched is believed to hold: no tooth's, which a firing may lift by hundreds of N m. */
static float mean_torque(sd_stage_driveline_t *self, float torque_nm) {
    self->mean_nm += (torque_nm - self->mean_nm) * (1.0f / MEAN_TEETH);
    return self->mean_nm;
}

/* A period of the firings is 2 positions / cylinders long; where the filter begins anew, so does the period. */
static void follow_winding(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline, const sd_tooth_t *tooth, float step_s,
                           float last_radps) {
    sd_driveline_out_f32_t *out = &self->out;
    if ((out->status.health == (uint8_t)SD_INVALID) || (self->begun_s <= 0.0f)) {
        self->begun_rad = out->twist_rad;
        self->begun_s = 1e-6f;
        self->positions = 0;
        self->still_s = 0.0f;
        out->winding_radps = 0.0f;
        return;
    }
    out->winding_radps = last_radps;
    self->begun_s += step_s;
    self->positions = (uint16_t)(self->positions + tooth->advance);
    if (self->positions >= driveline->firing_positions) {
        out->winding_radps = (out->twist_rad - self->begun_rad) / self->begun_s;
        self->begun_rad = out->twist_rad;
        self->begun_s = 1e-6f;
        self->positions = 0;
    }
    const bool fast = __builtin_fabsf(out->winding_radps) > driveline->tables.moving_radps;
    self->still_s = fast ? 0.0f : self->still_s + step_s;
    out->moving = (self->still_s < driveline->tables.moving_hold_s) ? 1u : 0u;
}

void sd_stage_driveline_tooth(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline, const sd_tooth_t *tooth,
                              const sd_stage_driveline_in_t *in) {
    const sd_driveline_tables_t *tables = &driveline->tables;
    const float step_s = (float)tooth->period_ticks * tables->tick_s;
    const bool known = in->torque.health != (uint8_t)SD_INVALID;
    /* over the interval; the viscous part of friction is the filter's */
    const float torque_nm = known ? 0.5f * (in->engine_nm + self->before_nm) - driveline->drag_nm : self->guard.torque_nm;
    const float mean_nm = mean_torque(self, torque_nm);
    const sd_driveline_tooth_f32_t seen = {
        .period_ticks = tooth->period_ticks,
        .advance = tooth->advance,
        .health = tooth->health,
        .gear = in->gear,
        .torque_nm = (self->guard.gear == in->gear) ? torque_nm : mean_nm,
        .place_rad = in->late_rad,
        .lead_rad = driveline->place_rad[tooth->position],
    };
    self->before_nm = in->engine_nm;
    self->tick = tooth->tick;
    const float winding_radps = self->out.winding_radps;
    sd_driveline_guard_step_f32(&self->guard, tables, &seen, &self->out);
    if (!known) { sd_status_worst_of(&self->out.status, SD_INVALID, SD_WHY_CONVERGING); }
    follow_winding(self, driveline, tooth, step_s, winding_radps);
    (void)sd_driveline_damping_step(&self->damping, &self->choice, self->out.winding_radps, self->out.status.health, step_s);
    self->torque_nms += seen.torque_nm * step_s;
    self->task_s += step_s;
}

void sd_stage_driveline_wheel(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline, uint16_t wheel, uint32_t tick) {
    if (wheel == driveline->wheel) { sd_driveline_guard_wheel_f32(&self->guard, &driveline->tables, tick - self->tick, 1u); }
}

/* ---- the 10 ms task ------------------------------------------------------------------------------------------------ */

static float road_nm(const sd_driveline_tables_t *t, float wheel_radps) {
    return (wheel_radps > 0.0f) ? t->rolling_nm + t->drag_nms2 * wheel_radps * wheel_radps : 0.0f;
}

void sd_stage_driveline_task(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline) {
    const uint8_t gear = self->guard.gear;
    const float task_s = self->task_s, torque_nms = self->torque_nms;
    self->task_s = self->torque_nms = 0.0f;
    if (gear == 0u) { /* none is in, or the guard filter begins anew */
        rest(self, (uint16_t)(self->out.status.why | (uint16_t)SD_WHY_NO_INPUT));
        return;
    }
    if (task_s <= 0.0f) { return; } /* no tooth came: the last values stand */
    const sd_driveline_bank_t *bank = &driveline->tables.gear[gear - 1u].bank;
    if (gear != self->hybrid_gear) {
        const uint8_t location = (self->guard.location != 0u) ? self->guard.location : 2u;
        if (sd_driveline_hybrid_init(&self->hybrid, bank, location) != SD_OK) {
            rest(self, SD_WHY_UNCALIBRATED);
            return;
        }
        self->hybrid_gear = gear;
    }
    const float wheel_radps = (self->hybrid.begun != 0u) ? self->hybrid.x[2] : self->guard.x[SD_DRIVELINE_WHEEL];
    sd_driveline_hybrid_step(&self->hybrid, bank, torque_nms / task_s, road_nm(&driveline->tables, wheel_radps),
                             self->guard.x[SD_DRIVELINE_SPEED] * bank->rpm_per_radps, &self->reference);
}
