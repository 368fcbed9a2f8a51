/* SPDX-License-Identifier: MIT */
/* Values of the stages into signals, by integers: units of the signal table, cylinders by their physical number. */
#include "sd_ecu_parts.h"
#include "sd_fixed_parts.h"
#include "sd_say_edge.h"

static uint32_t physical(const sd_calibration_t *page, uint32_t firing) { return page->firing_order[firing] - 1u; }

static float to_nm(sd_q31_t x, float base) { return sd_scaled_to_float(sd_scaled_mul(sd_scaled_q31(x), sd_scaled_of(base))); }

/* In 2^-20 deg: a cycle of 720 deg has 30 bits. */
static void say_angle(sd_signals_t *s, const sd_calibration_t *page, const sd_tooth_t *tooth) {
    const uint32_t cycle = 720u << 20, pitch = (360u << 20) / page->positions;
    const sd_scaled_t first = sd_scaled_of(page->position_0_deg);
    const uint32_t angle = (uint32_t)sd_scaled_fit(first.mantissa, first.exponent - 31 + 20) + tooth->cycle_position * pitch;
    s->crank_angle_deg = sd_scaled_to_float(sd_scaled_narrow((int32_t)((angle >= cycle) ? angle - cycle : angle), -20));
}

float sd_ecu_say_edge(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth) {
    const sd_crank_t *crank = &self->crank;
    sd_signals_t *s = &self->say.signals;
    self->say.flags[SD_OWNER_CRANK] = tooth->health | ((uint32_t)tooth->why << 8);
    s->crank_edge_class = sd_float_int(tooth->edge_class);
    s->crank_tooth = sd_float_int(tooth->position);
    s->crank_phase_known = sd_float_int(tooth->phase_known);
    say_angle(s, page, tooth);
    if (tooth->period_ticks == 0u) { return 0.0f; }
    /* sd_crank_motion_of, with as few divisions as there can be. */
    const sd_crank_clock_t *lead = &crank->clocks[crank->now].clock[crank->clocks[crank->now].leader];
    const sd_scaled_t tick_hz = sd_scaled_of(page->tick_hz);
    const sd_scaled_t turn_ticks = sd_scaled_make((int64_t)crank->turn_spacings * tooth->period_ticks, 0);
    const sd_scaled_t turns_per_s = sd_scaled_div(sd_scaled_mul(sd_scaled_int((int32_t)tooth->span_spacings), tick_hz), turn_ticks);
    /* 1/64 tick: by the exponent, since 64 times it has more than 32 bits where a tooth takes more than 2^22 ticks. */
    const sd_scaled_t period = sd_scaled_int(lead->period), grown = sd_scaled_mul(sd_scaled_narrow(-lead->change, 6), tick_hz);
    const sd_scaled_t shrinks = sd_scaled_div(grown, sd_scaled_mul(period, period));
    s->crank_speed_rpm = sd_scaled_to_float(sd_scaled_mul(turns_per_s, sd_scaled_int(60)));
    s->crank_acceleration_radps2 = sd_scaled_to_float(sd_scaled_mul(sd_scaled_mul(turns_per_s, sd_scaled_of(6.2831853f)), shrinks));
    return 0.0f; /* nobody here asks for it */
}

void sd_say_lost_angle(sd_publish_t *say, uint8_t health, uint16_t why) {
    sd_signals_t *s = &say->signals;
    sd_publish_judge(say, SD_OWNER_CRANK, &(sd_status_t){ .health = health, .why = why });
    s->crank_edge_class = sd_float_int(SD_EDGE_UNSYNCED);
    s->crank_phase_known = 0.0f;
    s->crank_speed_rpm = 0.0f;
    s->crank_acceleration_radps2 = 0.0f;
}

void sd_say_inputs(sd_publish_t *say, const sd_inputs_t *inputs) {
    const uint32_t all = 0xffffffffu >> (32u - SD_INPUT_COUNT);
    const uint32_t stale = inputs->seen & ~inputs->fresh, missing = all & ~inputs->seen;
    for (uint32_t i = 0; i < 2u; ++i) {
        say->signals.inputs_stale[i] = sd_float_int((int32_t)((stale >> (16u * i)) & 0xffffu));
        say->signals.inputs_missing[i] = sd_float_int((int32_t)((missing >> (16u * i)) & 0xffffu));
    }
    sd_publish_judge(say, SD_OWNER_INPUTS, &(sd_status_t){ .health = SD_VALID });
}

void sd_fixed_say_torque(sd_publish_t *say, const sd_fourier_q31_t *torque) {
    say->signals.torque_mass_nm = to_nm(torque->torque, torque->torque_base_nm);
    say->signals.torque_innovation_j = to_nm(torque->innovation, torque->energy_base_j);
}

static float scaled_by(sd_q31_t x, int32_t exponent) {
    sd_scaled_t a = sd_scaled_q31(x);
    a.exponent += exponent;
    return sd_scaled_to_float(a);
}

void sd_fixed_say_verdict(sd_ecu_t *self, const sd_calibration_t *page, const sd_wheel_verdict_q31_t *v) {
    sd_signals_t *s = &self->say.signals;
    const float cylinder = sd_float_int(page->firing_order[v->firing]);
    s->firing_cylinder = cylinder;
    s->misfire_monitor = sd_float_int(SD_NOT_JUDGED);
    s->misfire_acceleration_radps2 = scaled_by(v->accel, page->wheel.accel_exponent);
    s->misfire_residual_radps2 = scaled_by(v->residual, page->wheel.accel_exponent);
    s->misfire_index = scaled_by(v->index, SD_WHEEL_INDEX_BITS);
    s->misfire_limit = (v->inhibit == 0u) ? sd_float_q31(self->misfire.wheel.config.definition) : 0.0f;
    s->misfire_verdict = sd_float_int(v->verdict);
    s->misfire_inhibit = sd_float_int(v->inhibit);
    s->misfire_firing = sd_float_int(v->firing);
    s->misfire_cylinder = cylinder;
    s->misfire_count = sd_float_int((int32_t)self->misfire.misfires);
}

void sd_fixed_say_mixture(sd_ecu_t *self, const sd_calibration_t *page) {
    sd_signals_t *s = &self->say.signals;
    sd_publish_judge(&self->say, SD_OWNER_AFR, &self->work.mixture_status);
    for (uint32_t i = 0; i < page->cylinders; ++i) {
        s->afr_cylinder_burned[physical(page, i)] = self->work.mixture.lambda[i];
        s->afr_cylinder_sd[physical(page, i)] = self->work.mixture.sd[i];
    }
    s->afr_slow = sd_float_int(self->mixture.slow);
}

void sd_fixed_say_trims(sd_ecu_t *self, const sd_calibration_t *page) {
    if (page->cylinders < 2u) { return; }
    float *const trim = self->say.signals.balance_trim;
    for (uint32_t i = 0; i < page->cylinders; ++i) { trim[physical(page, i)] = sd_float_q31(self->trims.trim[i]); }
}
