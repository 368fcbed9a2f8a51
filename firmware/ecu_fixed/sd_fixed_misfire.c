/* SPDX-License-Identifier: MIT */
#include "sd_fixed_misfire.h"

#include <string.h>

#define FUEL_UNKNOWN (-1.0f)

static sd_scaled_t within(sd_scaled_t x, float low, float high) {
    const sd_scaled_t least = sd_scaled_of(low), most = sd_scaled_of(high);
    return sd_scaled_less(x, least) ? least : sd_scaled_less(most, x) ? most : x;
}

/* As sd_calibration_wheel. */
static sd_wheel_config_q31_t config_of(const sd_calibration_t *page, const sd_parameters_t *p, sd_scaled_t work_per_mg, uint32_t method) {
    const sd_scaled_t of_torque_mg = sd_scaled_div(sd_scaled_mul(sd_scaled_of(p->misfire_torque_min_nm), sd_scaled_of(3.14159265f)),
                                                   sd_scaled_of(p->misfire_work_per_fuel_jpmg));
    const sd_scaled_t given_mg = sd_scaled_of(p->misfire_fuel_min_mg), cylinders = sd_scaled_int(page->cylinders);
    const sd_scaled_t fuel_min_mg = sd_scaled_less(of_torque_mg, given_mg) ? given_mg : of_torque_mg;
    const sd_scaled_t change = sd_scaled_mul(sd_scaled_int(2), sd_scaled_of(p->misfire_shift_speed_change)); /* of the square */
    const sd_scaled_t start = sd_scaled_mul(sd_scaled_of(p->misfire_start_inhibit_cycles), cylinders);
    const sd_scaled_t resumed = sd_scaled_mul(sd_scaled_of(p->misfire_resume_inhibit_cycles), cylinders);
    return (sd_wheel_config_q31_t){ .definition = sd_from_float_q31(p->misfire_misfire_below),
                                    .work_min = sd_scaled_to_q31(within(sd_scaled_mul(fuel_min_mg, work_per_mg), 1e-6f, 0.999f)),
                                    .speed_change = sd_scaled_to_q31(within(change, 1e-3f, 0.999f)),
                                    .start_firings = (uint16_t)sd_scaled_floor(start),
                                    .hold_firings = (uint16_t)sd_scaled_floor(resumed),
                                    .kind = (uint8_t)(method - 1u) };
}

sd_result_t sd_fixed_misfire_init(sd_fixed_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const uint32_t method = sd_scaled_floor(sd_scaled_of(p->misfire_method));
    sd_scaled_t work_per_mg = sd_scaled_of(p->misfire_work_per_fuel_jpmg);
    work_per_mg.exponent -= page->wheel.work_exponent;
    sd_wheel_q31_t wheel;
    memset(&wheel, 0, sizeof wheel);
    if (method != 0u) {
        const sd_wheel_config_q31_t config = config_of(page, p, work_per_mg, method);
        if (sd_wheel_init_q31(&wheel, &config, &page->wheel) != SD_OK) { return SD_ERR_CONFIG; }
    }
    self->wheel = wheel;
    self->runs = (method != 0u) ? 1u : 0u;
    self->status = (sd_status_t){ .health = SD_INVALID, .why = (method != 0u) ? SD_WHY_CONVERGING : SD_WHY_NOT_BUILT };
    self->work_per_mg = sd_scaled_to_float(work_per_mg);
    self->converted_mg = FUEL_UNKNOWN;
    self->work = -1;
    self->doubt = 0;
    return SD_OK;
}

void sd_fixed_misfire_restart(sd_fixed_misfire_t *self) {
    if (self->runs == 0u) { return; }
    sd_wheel_restart_q31(&self->wheel);
    self->status = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_CONVERGING };
}

void sd_fixed_misfire_spurious(sd_fixed_misfire_t *self, const sd_calibration_t *page) { self->doubt = (uint16_t)(2u * page->positions); }

uint32_t sd_fixed_misfire_tooth(sd_fixed_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg) {
    if (self->runs == 0u) { return 0u; }
    const sd_wheel_tooth_t seen = { .cycle_position = tooth->cycle_position,
                                    .advance = tooth->advance,
                                    .period_ticks = tooth->period_ticks,
                                    .trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u };
    if (seen.trusted == 0u) { self->doubt = page->positions; }
    self->doubt = (self->doubt > seen.advance) ? (uint16_t)(self->doubt - seen.advance) : 0u;
    if (sd_bits_of(fuel_mg) != sd_bits_of(self->converted_mg)) {
        const sd_scaled_t work = sd_scaled_mul(sd_scaled_of(fuel_mg), sd_scaled_of(self->work_per_mg));
        self->converted_mg = fuel_mg;
        self->work = (sd_bits_order(fuel_mg) >= 0) ? sd_scaled_to_q31(work) : -1;
    }
    return sd_wheel_tooth_q31(&self->wheel, &page->wheel, &seen, self->work);
}

void sd_fixed_misfire_judge(sd_fixed_misfire_t *self, const sd_calibration_t *page, uint32_t firing, uint32_t inhibit,
                            sd_wheel_verdict_q31_t *v) {
    const uint32_t begins = (uint32_t)SD_INHIBIT_START | (uint32_t)SD_INHIBIT_ESTIMATE;
    const uint32_t doubtful = (self->doubt != 0u) ? (uint32_t)SD_INHIBIT_OUTSIDE : 0u;
    sd_wheel_judge_q31(&self->wheel, &page->wheel, firing, inhibit | doubtful, v);
    self->status = (sd_status_t){ .health = SD_VALID, .rejected = self->wheel.rejected };
    if (v->inhibit != 0u) {
        self->status.health = SD_INVALID;
        self->status.why = ((v->inhibit & begins) != 0u) ? (uint16_t)SD_WHY_CONVERGING : (uint16_t)SD_WHY_REJECTED;
    } else if (v->verdict == (uint8_t)SD_MISFIRE) {
        self->misfires++;
    }
}
