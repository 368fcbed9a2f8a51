/* SPDX-License-Identifier: MIT */
#include "sd_stage_airpath.h"

#include <string.h>

#include "sd_math.h"

#define SPEED_FOLLOWS    0.25f /* a step: 40 ms, a firing of six cylinders at 500 rpm */
#define SPEED_LEAST_RPM  300.0f
#define TRACKING_FOLLOWS 0.02f /* a step: half a second */
#define KPA_PER_BAR      100.0f

static const uint8_t noisy[SD_AIRPATH_NOISY] = { SD_INPUT_AIR_FLOW, SD_INPUT_AIR_INTAKE_PRESSURE, SD_INPUT_EXHAUST_PRESSURE };
static const uint8_t prompt[] = { SD_INPUT_AIR_FLOW,     SD_INPUT_AIR_INTAKE_PRESSURE, SD_INPUT_EXHAUST_PRESSURE,
                                  SD_INPUT_EGR_POSITION, SD_INPUT_VGT_POSITION };

static uint32_t steps_of(float seconds, float period_s) { return (uint32_t)(seconds / period_s + 0.5f); }

sd_result_t sd_stage_airpath_configure(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const float period_s = page->airpath.period_s;
    const sd_cusum_thresholds_t thresholds = { .detect = p->airpath_detect, .isolate = p->airpath_isolate };
    if (page->airpath.present == 0u) { return SD_OK; }
    if (!sd_cusum_thresholds_ok(&thresholds)) { return SD_ERR_CONFIG; }
    self->config = (sd_airpath_config_t){ .settle_steps = steps_of(p->airpath_settle_s, period_s),
                                          .window_steps = steps_of(p->airpath_window_s, period_s),
                                          .thresholds = thresholds };
    self->late_s = p->airpath_late_s;
    self->tracking = p->airpath_tracking;
    self->stuck_steps = steps_of(p->airpath_stuck_s, period_s);
    return SD_OK;
}

sd_result_t sd_stage_airpath_init(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    sd_stage_airpath_t begun;
    memset(&begun, 0, sizeof begun);
    if (sd_stage_airpath_configure(&begun, page, p) != SD_OK) { return SD_ERR_CONFIG; }
    sd_airpath_start(&begun.bank);
    *self = begun;
    return SD_OK;
}

/* ---- what inputs are worth ------------------------------------------------------------------------------------- */

static bool any_late(const sd_stage_airpath_t *self, const sd_inputs_t *inputs, uint32_t tick, float tick_hz) {
    bool late = false;
    for (uint32_t i = 0; i < sizeof prompt; ++i) {
        const int32_t age_ticks = (int32_t)(tick - inputs->reading[prompt[i]].tick);
        late = late || ((float)age_ticks > self->late_s * tick_hz);
    }
    return late;
}

/* The longest for which a noisy sensor has read the same; a new reading of the same value counts, no new one does not. */
static uint32_t longest_same(sd_stage_airpath_t *self, const sd_inputs_t *inputs) {
    uint32_t longest = 0;
    for (uint32_t i = 0; i < (uint32_t)SD_AIRPATH_NOISY; ++i) {
        sd_airpath_watch_t *w = &self->watch[i];
        const sd_reading_t *now = &inputs->reading[noisy[i]];
        const bool other = (now->value > w->value) || (now->value < w->value);
        if (other) {
            w->same_steps = 0;
        } else if ((now->tick != w->tick) && (w->same_steps < UINT32_MAX)) {
            w->same_steps++;
        }
        w->value = now->value;
        w->tick = now->tick;
        if (w->same_steps > longest) { longest = w->same_steps; }
    }
    return longest;
}

static uint8_t tracking_of(sd_stage_airpath_t *self, const sd_inputs_t *inputs) {
    static const uint8_t position[SD_AIRPATH_ACTUATORS] = { SD_INPUT_EGR_POSITION, SD_INPUT_VGT_POSITION };
    static const uint8_t command[SD_AIRPATH_ACTUATORS] = { SD_INPUT_EGR_COMMAND, SD_INPUT_VGT_COMMAND };
    uint32_t bits = 0;
    for (uint32_t i = 0; i < (uint32_t)SD_AIRPATH_ACTUATORS; ++i) {
        const bool known = sd_inputs_fresh(inputs, (sd_input_t)position[i]) && sd_inputs_fresh(inputs, (sd_input_t)command[i]);
        const float now = known ? inputs->reading[position[i]].value - inputs->reading[command[i]].value : 0.0f;
        self->deviation[i] += TRACKING_FOLLOWS * (now - self->deviation[i]);
        if (!sd_within(self->deviation[i], -self->tracking, self->tracking)) { bits |= 1u << i; }
    }
    return (uint8_t)bits;
}

/* ---- a step ---------------------------------------------------------------------------------------------------- */

static sd_airpath_in_t measured(const sd_stage_airpath_t *self, const sd_inputs_t *inputs, uint8_t cylinders) {
    const float strokes_ps = self->speed_rpm * (1.0f / 120.0f) * (float)cylinders;
    return (sd_airpath_in_t){ .speed_rpm = self->speed_rpm,
                              .air_gps = sd_inputs_value(inputs, SD_INPUT_AIR_FLOW),
                              .fuel_gps = 1e-3f * strokes_ps * sd_inputs_value(inputs, SD_INPUT_FUEL_INJECTED),
                              .charge_k = sd_inputs_value(inputs, SD_INPUT_AIR_CHARGE_TEMPERATURE),
                              .egr_k = sd_inputs_value(inputs, SD_INPUT_EGR_TEMPERATURE),
                              .exhaust_k = sd_inputs_value(inputs, SD_INPUT_EXHAUST_TEMPERATURE),
                              .egr_opening = sd_inputs_value(inputs, SD_INPUT_EGR_POSITION),
                              .vgt_position = sd_inputs_value(inputs, SD_INPUT_VGT_POSITION),
                              .intake_kpa = KPA_PER_BAR * sd_inputs_value(inputs, SD_INPUT_AIR_INTAKE_PRESSURE),
                              .exhaust_kpa = KPA_PER_BAR * sd_inputs_value(inputs, SD_INPUT_EXHAUST_PRESSURE) };
}

static bool follow_speed(sd_stage_airpath_t *self, const sd_stage_airpath_crank_t *crank) {
    if ((crank->health == (uint8_t)SD_INVALID) || !(crank->speed_rpm > SPEED_LEAST_RPM)) {
        self->speed_rpm = 0.0f;
        return false;
    }
    self->speed_rpm = (self->speed_rpm > 0.0f) ? self->speed_rpm + SPEED_FOLLOWS * (crank->speed_rpm - self->speed_rpm) : crank->speed_rpm;
    return true;
}

void sd_stage_airpath_step(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_inputs_t *inputs,
                           const sd_stage_airpath_crank_t *crank, uint32_t tick, sd_stage_airpath_out_t *out) {
    const sd_airpath_tables_t *tables = &page->airpath;
    const bool turns = follow_speed(self, crank);
    const uint32_t same_steps = longest_same(self, inputs);
    const bool stuck = same_steps >= self->stuck_steps;
    sd_status_t known = { .health = SD_VALID };
    sd_inputs_judge(inputs, SD_OWNER_AIRPATH, &known);
    out->tracking = tracking_of(self, inputs);
    if (!turns || stuck || (known.health == (uint8_t)SD_INVALID)) {
        sd_airpath_wait(&self->bank, &out->bank);
        if (stuck) { sd_status_worst_of(&out->bank.status, SD_INVALID, SD_WHY_REJECTED); }
        if (!turns) { sd_status_worst_of(&out->bank.status, SD_INVALID, SD_WHY_STALL); }
    } else if ((same_steps > 0u) || any_late(self, inputs, tick, page->tick_hz)) {
        sd_airpath_hold(&self->bank, tables, &self->config, &out->bank);
    } else {
        const sd_airpath_in_t in = measured(self, inputs, crank->cylinders);
        sd_airpath_step(&self->bank, tables, &self->config, &in, &out->bank);
    }
    sd_status_worst_of(&out->bank.status, known.health, known.why);
}
