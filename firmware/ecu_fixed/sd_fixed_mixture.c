/* SPDX-License-Identifier: MIT */
#include "sd_fixed_mixture.h"

#include <string.h>

#include "sd_afr.h"

enum { NO_EXHAUST, NOT_BUILT, RUNS };
enum { SETTLE = 8 }; /* cycles */

#define NO_SAMPLE    INT32_MIN
#define START_LAMBDA 0.5f

static bool runs(const sd_fixed_mixture_t *self) { return self->present == (uint8_t)RUNS; }

/* ---- init ------------------------------------------------------------------------------------------------------ */

static sd_afr_point_config_t point_of(const sd_calibration_t *page, const sd_parameters_t *p) {
    sd_afr_point_config_t config = { .cycle_positions = (uint16_t)(2u * page->positions), .cylinders = page->cylinders,
                                     .gain_mass = p->afr_gain_mass, .turbine_drop = p->afr_turbine_drop,
                                     .turbine_rpm = p->afr_turbine_rated_rpm };
    for (uint32_t i = 0; i < page->cylinders; ++i) { config.firing_position[i] = page->firing_position[i]; }
    return config;
}

static sd_afr_chain_config_t chain_of(const sd_calibration_t *page, const sd_parameters_t *p) {
    const uint32_t half = page->cylinders / 2u;
    return (sd_afr_chain_config_t){ .cycle_positions = (uint16_t)(2u * page->positions), .cylinders = page->cylinders,
                                    .harmonics = (uint8_t)((half < 2u) ? 1u : half), .settle_steps = 0,
                                    .tau1_s = page->afr.tau1_s, .tau2_s = page->afr.tau2_s,
                                    .gain_air = p->afr_gain_air, .gain_cylinder = p->afr_gain_cylinder,
                                    .inversion_gain = p->afr_inversion_gain, .inversion_floor = p->afr_inversion_floor };
}

sd_result_t sd_fixed_mixture_init(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const uint32_t method = sd_scaled_floor(sd_scaled_add(sd_scaled_of(p->afr_method), sd_scaled_of(0.5f)));
    const bool built = (page->afr.present != 0u) && (method >= (uint32_t)SD_AFR_OSCILLATORS);
    const sd_afr_point_config_t point = point_of(page, p);
    const sd_afr_chain_config_t chain = chain_of(page, p);
    const bool ok = (sd_afr_point_check_q31(&point, &page->afr) == SD_OK) && (sd_afr_chain_check_q31(&chain) == SD_OK);
    if (built && !ok) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->present = (uint8_t)(built ? RUNS : (page->afr.present != 0u) ? NOT_BUILT : NO_EXHAUST);
    if (!built) { return SD_OK; }
    (void)sd_afr_point_init_q31(&self->point, &point, &page->afr);
    (void)sd_afr_chain_init_q31(&self->chain, &chain);
    self->cycle_positions = point.cycle_positions;
    self->oscillators = (method == (uint32_t)SD_AFR_OSCILLATORS) ? 1u : 0u;
    return SD_OK;
}

void sd_fixed_mixture_restart(sd_fixed_mixture_t *self) {
    sd_afr_chain_restart_q31(&self->chain);
    self->cycles = 0;
    self->waiting_count = 0;
}

/* ---- a tooth --------------------------------------------------------------------------------------------------- */

static void add(sd_fixed_mean_t *mean, sd_q31_t x) {
    mean->sum += x;
    mean->count++;
}

static sd_q31_t take(sd_fixed_mean_t *mean, bool wanted, sd_q31_t otherwise) {
    const uint32_t count = mean->count;
    const int64_t sum = mean->sum;
    mean->sum = 0;
    mean->count = 0;
    if ((count == 0u) || !wanted) { return otherwise; }
    return (count == 1u) ? (sd_q31_t)sum : (sd_q31_t)(sum / (int64_t)count);
}

void sd_fixed_mixture_sample(sd_fixed_mixture_t *self, float lambda, float stoichiometric) {
    /* 1 - (1 + s)/(1 + s L) = s (L - 1)/(1 + s L) */
    const sd_scaled_t one = sd_scaled_int(1), s = sd_scaled_of(stoichiometric), l = sd_scaled_of(lambda);
    const sd_scaled_t air = sd_scaled_div(sd_scaled_mul(s, sd_scaled_sub(l, one)), sd_scaled_add(one, sd_scaled_mul(s, l)));
    add(&self->air, sd_scaled_to_q31(air));
    self->cycle_samples++;
}

void sd_fixed_mixture_pressure(sd_fixed_mixture_t *self, float bar) {
    sd_scaled_t share = sd_scaled_of(bar);
    share.exponent -= 4; /* SD_EXHAUST_BAR */
    add(&self->pressure, sd_scaled_to_q31(share));
}

bool sd_fixed_mixture_takes_pressure(const sd_fixed_mixture_t *self) { return runs(self) && (sd_bits_order(self->point.gain_mass) > 0); }

static void wait_for(sd_fixed_mixture_t *self, sd_q31_t air, sd_q31_t pressure) {
    if (self->waiting_count >= SD_MIXTURE_WAITING) { return; } /* coasted over half a wheel: the angle is about to be lost */
    const uint32_t at = (self->waiting_first + self->waiting_count) % SD_MIXTURE_WAITING;
    self->waiting_air[at] = air;
    self->waiting_pressure[at] = pressure;
    self->waiting_count++;
}

static void step(sd_fixed_mixture_t *self, const sd_calibration_t *page, uint32_t position, sd_q31_t air, sd_q31_t pressure) {
    sd_exhaust_now_q31_t now;
    if (self->placed == 0u) { return; }
    sd_exhaust_step_q31(&self->point.exhaust, page->afr.psi_q31, position, &now);
    if (pressure > 0) { sd_exhaust_measured_q31(&self->point.exhaust, pressure); }
    sd_afr_chain_step_q31(&self->chain, page->fourier.sine_q31, &now, position, air);
    if (self->chain.observer.running == 0u) { self->cycles = 0; }
}

static void step_oldest(sd_fixed_mixture_t *self, const sd_calibration_t *page) {
    const uint32_t position = self->waiting_position, first = self->waiting_first;
    self->waiting_position = (uint16_t)((position + 1u == self->cycle_positions) ? 0u : position + 1u);
    self->waiting_first = (uint8_t)((first + 1u) % SD_MIXTURE_WAITING);
    self->waiting_count--;
    step(self, page, position, self->waiting_air[first], self->waiting_pressure[first]);
}

bool sd_fixed_mixture_tooth(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, uint32_t most) {
    const bool single = tooth->advance == 1u; /* across a mark the mean belongs to no one position */
    const sd_q31_t air = take(&self->air, single, NO_SAMPLE), pressure = take(&self->pressure, single, 0);
    if (!runs(self)) { return false; }
    if ((self->waiting_count == 0u) && single && (most > 0u)) {
        step(self, page, tooth->cycle_position, air, pressure);
        return false;
    }
    if (self->waiting_count == 0u) {
        const uint32_t cycle = self->cycle_positions;
        self->waiting_position = (uint16_t)((tooth->cycle_position + cycle + 1u - tooth->advance) % cycle);
    }
    for (uint32_t left = tooth->advance; left > 1u; --left) { wait_for(self, NO_SAMPLE, 0); }
    wait_for(self, air, pressure);
    for (uint32_t i = 0; (i < most) && (self->waiting_count > 0u); ++i) { step_oldest(self, page); }
    return most > 1u;
}

/* ---- the end of a cycle ---------------------------------------------------------------------------------------- */

void sd_fixed_mixture_read(sd_fixed_mixture_t *self, const sd_afr_conditions_t *at, sd_afr_estimate_t *out, sd_status_t *status) {
    memset(out, 0, sizeof *out);
    if (!runs(self)) {
        const bool not_built = self->present == (uint8_t)NOT_BUILT;
        *status = (sd_status_t){ .health = SD_INVALID, .why = not_built ? SD_WHY_NOT_BUILT : SD_WHY_UNCALIBRATED };
        return;
    }
    const bool running = self->chain.observer.running != 0u;
    const sd_scaled_t mean = running ? sd_afr_chain_mean_q31(&self->chain) : sd_scaled_of(START_LAMBDA);
    if (running && (self->cycles < UINT32_MAX)) { self->cycles++; }
    (void)sd_afr_point_begin_q31(&self->point, at, mean);
    *status = sd_afr_chain_status_q31(&self->chain);
    const bool settled = (self->slow == 0u) && (self->cycles >= SETTLE);
    if (!settled) { sd_status_worst_of(status, SD_DEGRADED, SD_WHY_CONVERGING); }
    if (self->cycle_samples == 0u) { sd_status_worst_of(status, SD_INVALID, SD_WHY_NO_INPUT); }
    self->cycle_samples = 0;
    sd_afr_chain_read_q31(&self->chain, out);
}

static void take_effect(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_scaled_t lags = sd_scaled_add(sd_scaled_of(page->afr.tau1_s), sd_scaled_of(page->afr.tau2_s));
    const sd_scaled_t turns = sd_scaled_mul(sd_scaled_of(self->point.at.speed_radps), lags);
    const uint8_t slow = sd_scaled_less(sd_scaled_of(p->afr_slow_mode_above), turns) ? 1u : 0u;
    sd_uego_gains_t gains;
    if (slow != self->slow) { self->cycles = 0; }
    self->slow = slow;
    if (self->oscillators != 0u) { sd_afr_point_gains_q31(&self->point, &page->afr, &gains); }
    sd_afr_chain_set_q31(&self->chain, page->fourier.sine_q31, self->point.step_s, (self->oscillators != 0u) ? &gains : NULL,
                         self->point.exhaust.charge);
    self->placed = 1;
}

bool sd_fixed_mixture_work(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    if (!runs(self)) { return false; }
    const sd_afr_progress_t progress = sd_afr_point_work_q31(&self->point, &page->afr, 0.0f);
    if (progress == SD_AFR_SET) { take_effect(self, page, p); }
    return progress == SD_AFR_MORE;
}
