/* SPDX-License-Identifier: MIT */
#include "sd_stage_torque.h"

#include "sd_math.h"

#define TIMER_SD_TICKS 0.28867513f /* of rounding down to a whole tick: 1 / sqrt(12) */

sd_result_t sd_stage_torque_init(sd_stage_torque_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_fourier_config_t config = sd_calibration_torque(page, p);
    const bool fixed = p->torque_fixed_point > 0.5f;
    const sd_result_t result = fixed ? sd_fourier_init_q31(&self->observer.q31, &config, &page->fourier)
                                     : sd_fourier_init_f32(&self->observer.f32, &config, &page->fourier);
    if (result == SD_OK) { self->fixed_point = fixed ? 1u : 0u; }
    return result;
}

void sd_stage_torque_jump(sd_stage_torque_t *self, sd_course_jump_t jump) {
    const bool shift = jump == SD_COURSE_SHIFTED;
    if (self->fixed_point != 0u) {
        if (shift) { sd_fourier_shift_revolution_q31(&self->observer.q31); } else { sd_fourier_restart_q31(&self->observer.q31); }
    } else {
        if (shift) { sd_fourier_shift_revolution_f32(&self->observer.f32); } else { sd_fourier_restart_f32(&self->observer.f32); }
    }
}

void sd_stage_torque_tooth(sd_stage_torque_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, sd_torque_out_t *out) {
    const uint8_t trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u;
    if (self->fixed_point != 0u) {
        out->mass_nm = sd_fourier_step_q31(&self->observer.q31, &page->fourier, tooth->cycle_position, tooth->advance, tooth->period_ticks,
                                           trusted);
        out->status = sd_fourier_status_q31(&self->observer.q31);
    } else {
        out->mass_nm = sd_fourier_step_f32(&self->observer.f32, &page->fourier, tooth->cycle_position, tooth->advance, tooth->period_ticks,
                                           trusted);
        out->status = sd_fourier_status_f32(&self->observer.f32);
    }
    sd_status_worst_of(&out->status, tooth->health, tooth->why);
}

void sd_stage_torque_end_cycle(sd_stage_torque_t *self) {
    self->ended = self->observer;
    self->ended_fixed_point = self->fixed_point;
}

void sd_stage_torque_cylinders(const sd_stage_torque_t *self, const sd_calibration_t *page, const sd_parameters_t *p, float speed_radps,
                               float intake_bar, sd_cylinders_out_t *out) {
    const sd_cylinder_map_t *map = &page->cylinder_map;
    const sd_fourier_config_t config = sd_calibration_torque(page, p);
    out->known = sd_cylinders_fit(map, &config) ? 1u : 0u;
    if (out->known == 0u) { return; }
    sd_fourier_estimate_t ended;
    if (self->ended_fixed_point != 0u) {
        sd_fourier_read_q31(&self->ended.q31, &ended);
    } else {
        sd_fourier_read_f32(&self->ended.f32, &ended);
    }
    const float spacing = p->torque_edge_sd_deg * SD_RAD_PER_DEG, timer = speed_radps * TIMER_SD_TICKS / page->tick_hz;
    const float tooth_error = sd_root(spacing * spacing + timer * timer);
    for (uint32_t i = 0; i < map->cylinders; ++i) {
        out->torque_nm[i] = sd_cylinders_torque(map, &ended, intake_bar, i);
        out->sd_nm[i] = sd_cylinders_sd(map, i, speed_radps, tooth_error);
    }
}
