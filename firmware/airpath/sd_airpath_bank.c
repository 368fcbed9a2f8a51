/* SPDX-License-Identifier: MIT */
#include "sd_airpath_bank.h"

#include <string.h>

#include "sd_math.h"

#define OBSERVERS   ((uint32_t)SD_AIRPATH_OBSERVERS)
#define RESIDUALS   ((uint32_t)SD_AIRPATH_RESIDUALS)
#define NUMBER_MAX  1e6f
#define FLOW_LEAST  1.0f  /* g/s: below it an engine does not run, and an offset over the flow says nothing */
#define SUSPECT     0.5f  /* of a fault of interest */

_Static_assert(sizeof(sd_airpath_bank_t) <= 1024, "goal: 1 KiB of state");
_Static_assert(sizeof(sd_airpath_bank_t) == 160, "without pointers, the same size on every target");

/* ---- ranges ---------------------------------------------------------------------------------------------------- */

static bool model_ok(const sd_airpath_model_t *m) {
    return sd_within(m->kappa, 1.0f, 1.5f) && sd_above_to(m->air_kpapgk, 0.0f, 1.0f) && sd_above_to(m->egr_kpapgk, 0.0f, 1.0f) &&
           sd_above_to(m->exhaust_kpapgk, 0.0f, 1.0f) && sd_within(m->exhaust_jpkgk, 200.0f, 400.0f) &&
           sd_within(m->ambient_kpa, 50.0f, 120.0f) && sd_within(m->rpm_most, 500.0f, 20000.0f) &&
           sd_all_within(m->emptying_ps, SD_AIRPATH_KNOTS, 0.0f, 1000.0f) && sd_all_within(m->egr_area_mm2, SD_AIRPATH_KNOTS, 0.0f, 1e5f) &&
           sd_all_within(m->turbine_area_mm2, SD_AIRPATH_KNOTS, 0.0f, 1e5f) &&
           sd_all_within(m->turbine_drop, SD_AIRPATH_DROP_KNOTS, 0.0f, 1.0f);
}

static bool observer_ok(const sd_nuio_table_t *o) {
    return sd_all_within(&o->m[0][0], sizeof *o / sizeof(float), -NUMBER_MAX, NUMBER_MAX); /* floats alone, without gaps */
}

bool sd_airpath_tables_ok(const sd_airpath_tables_t *t) {
    if (t->present == 0u) { return true; }
    return (t->present == 1u) && sd_above_to(t->period_s, 0.0f, 0.1f) && sd_above_to(t->emptying_low_ps, 0.0f, 1000.0f) &&
           sd_above_to(t->emptying_high_ps, t->emptying_low_ps, 1000.0f) && sd_above_to(t->fault[0], 0.0f, 1e4f) &&
           sd_above_to(t->fault[1], 0.0f, 1e4f) && model_ok(&t->model) && observer_ok(&t->observer[0]) && observer_ok(&t->observer[1]) &&
           sd_cusum_tables_ok(&t->cusum) && (t->cusum.residuals == (uint8_t)RESIDUALS);
}

/* ---- phases ---------------------------------------------------------------------------------------------------- */

void sd_airpath_start(sd_airpath_bank_t *self) { memset(self, 0, sizeof *self); }

static void enter(sd_airpath_bank_t *self, sd_airpath_phase_t phase) {
    self->phase = (uint8_t)phase;
    self->steps = 0;
}

/* What the phase means for the outputs, but for the decision. */
static void say(const sd_airpath_bank_t *self, sd_airpath_out_t *out) {
    memset(out, 0, sizeof *out);
    out->phase = self->phase;
    out->status.rejected = self->rejected;
    for (uint32_t i = 0; i < RESIDUALS; ++i) { out->residual_kpa[i] = self->residual[i]; }
    if (self->phase != (uint8_t)SD_AIRPATH_DECIDES) {
        sd_status_worst_of(&out->status, SD_INVALID, SD_WHY_CONVERGING);
    } else if (self->offsets.suspect != 0u) {
        sd_status_worst_of(&out->status, SD_DEGRADED, SD_WHY_LEARNED);
    }
}

static void decide(sd_airpath_bank_t *self, const sd_airpath_tables_t *tables, sd_airpath_out_t *out) {
    out->since_s = tables->period_s * (float)out->decision.since_steps;
    const uint32_t named = out->decision.named;
    out->fault = (uint8_t)SD_AIRPATH_NO_FAULT;
    if ((out->decision.groups & (uint8_t)SD_AIRPATH_UNCLEAR) == (uint8_t)SD_AIRPATH_UNCLEAR) { /* no single actuator explains them */
        out->fault = (uint8_t)SD_AIRPATH_UNCLEAR;
    } else if (named != 0u) {
        const uint32_t group = tables->cusum.group[named - 1u];
        out->fault = (uint8_t)((group < 2u) ? (1u << group) : (uint32_t)SD_AIRPATH_UNCLEAR);
    } else { /* nothing is sure */ }
    self->said |= (out->fault != (uint8_t)SD_AIRPATH_NO_FAULT) ? 1u : 0u;
}

void sd_airpath_wait(sd_airpath_bank_t *self, sd_airpath_out_t *out) {
    enter(self, SD_AIRPATH_WAITS);
    sd_cusum_start(&self->cusum);
    sd_airpath_offsets_drop(&self->offsets);
    say(self, out);
}

void sd_airpath_hold(sd_airpath_bank_t *self, const sd_airpath_tables_t *tables, const sd_airpath_config_t *config, sd_airpath_out_t *out) {
    self->rejected = (uint16_t)(self->rejected + ((self->rejected < UINT16_MAX) ? 1u : 0u));
    say(self, out);
    sd_status_worst_of(&out->status, SD_DEGRADED, SD_WHY_REJECTED);
    if (self->phase != (uint8_t)SD_AIRPATH_DECIDES) { return; }
    sd_cusum_read(&self->cusum, &tables->cusum, &config->thresholds, &out->decision);
    decide(self, tables, out);
}

/* ---- a step ---------------------------------------------------------------------------------------------------- */

static void begin(sd_airpath_bank_t *self, const sd_airpath_tables_t *tables, const sd_airpath_in_t *in, const sd_airpath_now_t *now) {
    float x[SD_AIRPATH_STATES];
    sd_airpath_rest(in, now, x);
    for (uint32_t i = 0; i < OBSERVERS; ++i) { sd_nuio_begin(&self->observer[i], &tables->observer[i], x); }
    sd_cusum_start(&self->cusum);
    sd_airpath_offsets_drop(&self->offsets);
    enter(self, SD_AIRPATH_SETTLES);
}

/* Both observers a period on; their residuals. */
static void observe(sd_airpath_bank_t *self, const sd_airpath_tables_t *tables, const sd_airpath_in_t *in, const sd_airpath_now_t *now,
                    float *residual) {
    const float y[SD_NUIO_OUTPUTS] = { in->intake_kpa, in->exhaust_kpa / now->per_exhaust };
    const float span = tables->emptying_high_ps - tables->emptying_low_ps;
    const float share = sd_clamp((now->emptying_ps - tables->emptying_low_ps) / span, 0.0f, 1.0f);
    for (uint32_t i = 0; i < OBSERVERS; ++i) {
        sd_nuio_estimate_t at;
        sd_airpath_flows_t flows;
        float rate[SD_AIRPATH_STATES];
        sd_nuio_look(&self->observer[i], &tables->observer[i], y, &at);
        sd_airpath_flow(&tables->model, now, at.x[SD_AIRPATH_PRESSURE], now->per_exhaust * at.x[SD_AIRPATH_EXHAUST], &flows);
        sd_airpath_rate(&tables->model, in, now, at.x, &flows, rate);
        sd_nuio_step(&self->observer[i], &tables->observer[i], &at, rate, share, tables->period_s);
        residual[i] = at.residual;
    }
}

static void learn(sd_airpath_bank_t *self, const sd_airpath_tables_t *tables, uint32_t window_steps, const float *residual,
    float flow_gps) {
    if (window_steps == 0u) {
        enter(self, SD_AIRPATH_DECIDES);
        return;
    }
    if (!sd_airpath_offsets_step(&self->offsets, window_steps, residual, flow_gps)) { return; }
    self->offsets.suspect = 0;
    for (uint32_t i = 0; i < RESIDUALS; ++i) {
        const float offset = self->offsets.per_flow[i] * flow_gps;
        if (!sd_within(offset, -SUSPECT * tables->fault[i], SUSPECT * tables->fault[i])) { self->offsets.suspect = 1; }
    }
    sd_airpath_point_keep(&self->point);
    self->said = 0;
    enter(self, SD_AIRPATH_DECIDES);
}

/* The operating point is on its way: what was summed belongs to another one. */
static void disturb(sd_airpath_bank_t *self) {
    sd_cusum_start(&self->cusum);
    sd_airpath_offsets_drop(&self->offsets);
}

void sd_airpath_step(sd_airpath_bank_t *self, const sd_airpath_tables_t *tables, const sd_airpath_config_t *config,
                     const sd_airpath_in_t *in, sd_airpath_out_t *out) {
    sd_airpath_now_t now;
    float residual[RESIDUALS];
    const float flow_gps = (in->air_gps > FLOW_LEAST) ? in->air_gps : FLOW_LEAST;
    sd_airpath_prepare(&tables->model, in, &now);
    if (self->phase == (uint8_t)SD_AIRPATH_WAITS) { begin(self, tables, in, &now); }
    observe(self, tables, in, &now, residual);
    if (!sd_all_within(residual, RESIDUALS, -NUMBER_MAX, NUMBER_MAX)) { /* it has run away, NaN included: begins anew */
        memset(self->residual, 0, sizeof self->residual);
        sd_airpath_wait(self, out);
        return;
    }
    sd_airpath_offsets_take(&self->offsets, residual, flow_gps, self->residual);
    self->steps += (self->steps < UINT32_MAX) ? 1u : 0u;
    const bool calm = sd_airpath_point_step(&self->point, tables->period_s, in->speed_rpm, in->fuel_gps);
    if (!calm) { disturb(self); }
    else if ((self->phase == (uint8_t)SD_AIRPATH_DECIDES) && (config->window_steps > 0u) && (self->said == 0u)
        && sd_airpath_point_left(&self->point)) {
        enter(self, SD_AIRPATH_LEARNS);
    }
    const uint8_t phase = self->phase;
    if ((phase == (uint8_t)SD_AIRPATH_SETTLES) && (self->steps > config->settle_steps)) {
        enter(self, (self->offsets.learned != 0u) ? SD_AIRPATH_DECIDES : SD_AIRPATH_LEARNS);
    } else if ((phase == (uint8_t)SD_AIRPATH_LEARNS) && calm) {
        learn(self, tables, config->window_steps, residual, flow_gps);
    }
    say(self, out);
    for (uint32_t i = 0; i < RESIDUALS; ++i) { out->offset_faults[i] = self->offsets.per_flow[i] * flow_gps / tables->fault[i]; }
    if (phase != (uint8_t)SD_AIRPATH_DECIDES) { return; }
    if (!calm) {
        sd_status_worst_of(&out->status, SD_DEGRADED, SD_WHY_CONVERGING);
        return;
    }
    sd_cusum_step(&self->cusum, &tables->cusum, &config->thresholds, self->residual, &out->decision);
    decide(self, tables, out);
}
