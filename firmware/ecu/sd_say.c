/* SPDX-License-Identifier: MIT */
#include "sd_say.h"

#include "sd_math.h"

static uint32_t physical(const sd_calibration_t *page, uint32_t firing) { return page->firing_order[firing] - 1u; }

void sd_say_tooth(sd_publish_t *say, const sd_calibration_t *page, const sd_tooth_t *tooth, const sd_crank_motion_t *motion) {
    sd_signals_t *s = &say->signals;
    say->flags[SD_OWNER_CRANK] = tooth->health | ((uint32_t)tooth->why << 8);
    const float angle_deg = page->position_0_deg + (float)tooth->cycle_position * (360.0f / (float)page->positions);
    s->crank_edge_class = (float)tooth->edge_class;
    s->crank_tooth = (float)tooth->position;
    s->crank_angle_deg = (angle_deg >= 720.0f) ? angle_deg - 720.0f : angle_deg;
    s->crank_phase_known = (float)tooth->phase_known;
    if (tooth->period_ticks > 0u) {
        s->crank_speed_rpm = motion->speed_radps * SD_RPM_PER_RADPS;
        s->crank_acceleration_radps2 = motion->acceleration_radps2;
    }
}

void sd_say_lost_angle(sd_publish_t *say, uint8_t health, uint16_t why) {
    sd_signals_t *s = &say->signals;
    sd_publish_judge(say, SD_OWNER_CRANK, &(sd_status_t){ .health = health, .why = why });
    s->crank_edge_class = (float)SD_EDGE_UNSYNCED;
    s->crank_phase_known = 0.0f;
    s->crank_speed_rpm = 0.0f;
    s->crank_acceleration_radps2 = 0.0f;
}

/* A float holds 24 bits exactly, so 32 inputs take two values. */
void sd_say_inputs(sd_publish_t *say, const sd_inputs_t *inputs) {
    const uint32_t all = 0xffffffffu >> (32u - SD_INPUT_COUNT);
    const uint32_t stale = inputs->seen & ~inputs->fresh, missing = all & ~inputs->seen;
    for (uint32_t i = 0; i < 2u; ++i) {
        say->signals.inputs_stale[i] = (float)((stale >> (16u * i)) & 0xffffu);
        say->signals.inputs_missing[i] = (float)((missing >> (16u * i)) & 0xffffu);
    }
    sd_publish_judge(say, SD_OWNER_INPUTS, &(sd_status_t){ .health = SD_VALID });
}

void sd_say_torque(sd_publish_t *say, const sd_torque_out_t *torque) {
    say->signals.torque_mass_nm = torque->mass_nm;
    say->signals.torque_innovation_j = torque->status.innovation;
    sd_publish_judge(say, SD_OWNER_TORQUE, &torque->status);
}

void sd_say_cylinders(sd_publish_t *say, const sd_calibration_t *page, const sd_cylinders_out_t *cylinders) {
    for (uint32_t i = 0; i < page->cylinder_map.cylinders; ++i) {
        say->signals.cycle_cylinder_torque_nm[physical(page, i)] = cylinders->torque_nm[i];
        say->signals.cycle_cylinder_sd_nm[physical(page, i)] = cylinders->sd_nm[i];
    }
}

void sd_say_firing(sd_publish_t *say, const sd_calibration_t *page, const sd_firings_out_t *firings) {
    const sd_firing_t *firing = &firings->firing;
    sd_signals_t *s = &say->signals;
    s->firing_cylinder = (float)page->firing_order[firing->index];
    s->firing_torque_nm = firing->torque_nm;
    s->firing_sd_nm = firing->sd_nm;
    s->firing_mean_nm = firing->mean_nm;
    s->firing_mean_sd_nm = firing->mean_sd_nm;
    s->firing_rough = (float)firings->rough;
}

void sd_say_pattern(sd_publish_t *say, const sd_firings_t *firings) {
    const sd_firings_pattern_t pattern = sd_firings_believed(firings);
    say->signals.wheel_learned_cycles = pattern.cycles;
    say->signals.wheel_pattern_sd_deg = pattern.sd_rad / SD_RAD_PER_DEG;
}

void sd_say_verdict(sd_publish_t *say, const sd_stage_misfire_out_t *out) {
    const sd_misfire_verdict_t *v = &out->verdict;
    sd_signals_t *s = &say->signals;
    s->misfire_monitor = (float)out->monitor;
    s->misfire_acceleration_radps2 = out->accel_radps2;
    s->misfire_residual_radps2 = out->residual_radps2;
    s->misfire_index = v->index;
    s->misfire_limit = v->limit;
    s->misfire_verdict = (float)v->verdict;
    s->misfire_inhibit = (float)v->inhibit;
    s->misfire_firing = (float)v->firing;
    s->misfire_cylinder = (float)v->cylinder;
}

void sd_say_misfires(sd_publish_t *say, const sd_calibration_t *page, const sd_misfire_t *monitor) {
    sd_signals_t *s = &say->signals;
    sd_misfire_report_t r;
    sd_misfire_read(monitor, &r);
    for (uint32_t i = 0; i < page->cylinders; ++i) {
        const uint32_t cylinder = physical(page, i);
        s->misfire_rate_200_percent[cylinder] = r.percent_200[cylinder];
        s->misfire_rate_1000_percent[cylinder] = r.percent_1000[cylinder];
    }
    s->misfire_continuous = (float)r.continuous;
    s->misfire_suspects = (float)r.suspects;
    s->misfire_lamp = (float)r.lamp;
    s->misfire_count = (float)r.misfires;
    s->misfire_partial_burns = (float)r.partial_burns;
}

void sd_say_mixture(sd_publish_t *say, const sd_calibration_t *page, const sd_mixture_out_t *out, const sd_stage_mixture_t *mixture) {
    sd_signals_t *s = &say->signals;
    sd_publish_judge(say, SD_OWNER_AFR, &out->status);
    for (uint32_t i = 0; i < page->cylinders; ++i) {
        s->afr_cylinder_burned[physical(page, i)] = out->burned[i];
        s->afr_cylinder_sd[physical(page, i)] = out->deviations.sd[i];
    }
    if (mixture->afr.config.cylinders == 0u) { return; } /* no exhaust in the page: all is 0 */
    s->afr_slow = (float)mixture->afr.slow;
    s->afr_late_s = mixture->delay.learned.late_s;
    s->afr_late_sd_s = mixture->delay.learned.late_sd_s;
    s->afr_lag = mixture->delay.learned.lag;
    s->afr_probing = (mixture->delay.probed != 0u) ? 1.0f : 0.0f;
}

void sd_say_trims(sd_publish_t *say, const sd_calibration_t *page, const sd_stage_trims_t *trims) {
    for (uint32_t i = 0; i < trims->balance.config.cylinders; ++i) { say->signals.balance_trim[physical(page, i)] = trims->trim[i]; }
}

void sd_say_driveline(sd_publish_t *say, const sd_stage_driveline_t *driveline) {
    sd_signals_t *s = &say->signals;
    const sd_driveline_out_f32_t *out = &driveline->out;
    const sd_driveline_hybrid_out_t *reference = &driveline->reference;
    s->driveline_location = (float)out->location;
    s->driveline_torsion_rad = out->twist_rad;
    s->driveline_winding_radps = out->winding_radps;
    s->driveline_shaft_nm = out->shaft_nm;
    s->driveline_wheel_speed_radps = out->wheel_radps;
    s->driveline_bias_nm = out->bias_nm;
    s->driveline_moving = (float)out->moving;
    s->driveline_damping_request_nm = driveline->damping.request_nm;
    s->driveline_reference_location = (float)reference->location;
    s->driveline_reference_torsion_rad = reference->x[0];
    for (uint32_t j = 0; j < (uint32_t)SD_DRIVELINE_LOCATIONS; ++j) { s->driveline_reference_residual_rpm[j] = reference->residual_rpm[j]; }
}
