/* SPDX-License-Identifier: MIT */
/* Document 004's chain in q31, sensor inversion and observer of cylinders: any state, any gas at the sensor, any sample. */
/* kernel: firmware/afr/sd_uego_q31.c firmware/afr/sd_afr_observer_q31.c firmware/afr/sd_afr_chain_q31.c */
#include "any_q31.h"
#include "sd_afr_chain.h"

static sd_afr_chain_q31_t self;
static int32_t sine[SD_UEGO_POSITIONS_MAX];

static void fill_uego(sd_uego_q31_t *uego, uint32_t cycle, uint32_t harmonics) {
    ANY_BYTES(*uego);
    for (uint32_t k = 0; k <= SD_UEGO_HARMONICS_MAX; k++) {
        uego->g_re[k] = any_gain(), uego->g_im[k] = any_gain();
        uego->h_re[k] = any_of(-INT32_MAX, INT32_MAX), uego->h_im[k] = any_of(-INT32_MAX, INT32_MAX);
    }
    uego->g_lag2 = any_gain(), uego->g_lag1 = any_gain(), uego->move2 = any_gain(), uego->move1 = any_gain();
    uego->tau1_s = any_float(1e-4f, 1.0f), uego->tau2_s = any_float(1e-4f, 1.0f);
    uego->gain = any_float(1e-9f, 0.1f), uego->floor = any_float(0.01f, 1.0f);
    uego->cycle_positions = (uint16_t)cycle;
    uego->harmonics = (uint8_t)harmonics;
    uego->oscillator = (uint8_t)any_upto(1u);
}

static void fill_state(uint32_t cycle, uint32_t harmonics) {
    ANY_BYTES(self);
    fill_uego(&self.uego, cycle, harmonics);
    self.observer.gain_air = any_gain(), self.observer.gain_cylinder = any_gain();
    self.observer.cylinder_gain = any_float(1e-9f, 100.0f);
    self.observer.cylinders = (uint8_t)any_of(1, SD_AFR_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_AFR_CYLINDERS_MAX; i++) { self.last[i] = any_scaled(); }
    self.change_square = any_scaled();
    self.cycles = (uint8_t)any_of(0, 8);
}

static sd_exhaust_now_q31_t any_gas(void) {
    sd_exhaust_now_q31_t now;
    ANY_BYTES(now);
    now.count = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_AFR_CYLINDERS_MAX; i++) { now.flowing[i] = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX - 1u); }
    return now;
}

static void call_all(uint32_t cycle, uint32_t harmonics) {
    const sd_exhaust_now_q31_t now = any_gas();
    sd_afr_estimate_t estimate;
    sd_uego_gains_t gains;
    for (uint32_t k = 0; k <= SD_UEGO_HARMONICS_MAX; k++) { gains.re[k] = any_float(-1e9f, 1e9f), gains.im[k] = any_float(-1e9f, 1e9f); }
    gains.lag2 = any_float(-1e9f, 1e9f), gains.lag1 = any_float(-1e9f, 1e9f);
    fill_state(cycle, harmonics);
    sd_afr_chain_step_q31(&self, sine, &now, any_u32(), any_q31());
    sd_afr_chain_move_q31(&self, any_u32(), any_float(-1e9f, 1e9f));
    fill_state(cycle, harmonics);
    sd_afr_chain_set_q31(&self, sine, any_float(-1.0f, 1.0f), any_bool() ? &gains : 0, any_q31());
    sd_afr_chain_read_q31(&self, &estimate);
    (void)sd_afr_chain_deviation_variance_q31(&self);
    (void)sd_afr_chain_lambda_q31(&self, any_u32());
    (void)sd_afr_chain_status_q31(&self);
}

int main(void) {
    for (uint32_t k = 0; k < SD_UEGO_POSITIONS_MAX; k++) { sine[k] = any_sine(); }
    for (uint32_t cycle = 24; cycle <= SD_UEGO_POSITIONS_MAX; cycle += 108u) { /* 24, 132, 240 */
        call_all(cycle, (uint32_t)any_of(1, SD_UEGO_HARMONICS_MAX));
    }
    return 0;
}
