/* SPDX-License-Identifier: MIT */
/* Document 004's chain in f32, sensor inversion and observer of cylinders: any bits in state, gas and sample, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/afr/sd_uego_f32.c firmware/afr/sd_afr_observer_f32.c firmware/afr/sd_afr_chain_f32.c */
#include "any.h"
#include "sd_afr_chain.h"

static sd_afr_chain_f32_t self;
static int32_t sine[SD_UEGO_POSITIONS_MAX];

static void fill_state(uint32_t cycle) {
    ANY_BYTES(self);
    self.uego.cycle_positions = (uint16_t)cycle;
    self.uego.harmonics = (uint8_t)any_of(1, SD_UEGO_HARMONICS_MAX);
    self.uego.oscillator = (uint8_t)any_upto(1u);
    self.observer.cylinders = (uint8_t)any_of(1, SD_AFR_CYLINDERS_MAX);
    self.cycles = (uint8_t)any_of(0, 8);
}

static void call_all(uint32_t cycle) {
    sd_exhaust_now_f32_t now;
    sd_afr_estimate_t estimate;
    sd_uego_gains_t gains;
    float any;
    ANY_BYTES(sine), ANY_BYTES(now), ANY_BYTES(gains);
    any = any_number();
    now.count = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_AFR_CYLINDERS_MAX; i++) { now.flowing[i] = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX - 1u); }
    fill_state(cycle);
    sd_afr_chain_step_f32(&self, sine, &now, any_u32(), any);
    sd_afr_chain_move_f32(&self, any_u32(), any);
    fill_state(cycle);
    sd_afr_chain_set_f32(&self, sine, any, any_bool() ? &gains : 0, any);
    sd_afr_chain_read_f32(&self, &estimate);
    (void)sd_afr_chain_deviation_variance_f32(&self);
    (void)sd_afr_chain_lambda_f32(&self, any_u32());
    (void)sd_afr_chain_status_f32(&self);
    sd_afr_chain_restart_f32(&self);
}

int main(void) {
    for (uint32_t cycle = 24; cycle <= SD_UEGO_POSITIONS_MAX; cycle += 108u) { call_all(cycle); } /* 24, 132, 240 */
    return 0;
}
