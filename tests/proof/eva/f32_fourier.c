/* SPDX-License-Identifier: MIT */
/* The torque observer in f32: any bits in state and gains, NaN included; any table, any tooth. Every twelfth number of positions. */
/* options: -eva-precision 0 -eva-slevel 60 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_fourier_f32.c */
#include "any.h"
#include "sd_fourier.h"

static volatile float kept;
static sd_fourier_f32_t self;
static sd_fourier_tables_t tables;

static void fill_state(uint32_t positions) {
    ANY_BYTES(self);
    self.harmonics = (uint8_t)any_of(1, SD_FOURIER_HARMONICS_MAX);
    self.positions = (uint16_t)positions;
    self.period_base_ticks = 16u + any_upto(UINT32_MAX - 16u);
}

static void call_all(uint32_t positions) {
    sd_fourier_estimate_t estimate;
    sd_fourier_config_t config;
    fill_state(positions);
    sd_fourier_advance_f32(&self, &tables, any_u32(), any_u32(), any_u32(), (uint8_t)any_upto(1u));
    fill_state(positions);
    kept = sd_fourier_torque_at_f32(&self, &tables, any_u32());
    sd_fourier_shift_revolution_f32(&self);
    sd_fourier_read_f32(&self, &estimate);
    (void)sd_fourier_status_f32(&self);
    (void)sd_fourier_health_f32(&self);
    sd_fourier_restart_f32(&self);
    ANY_BYTES(config);
    config.positions = (uint8_t)positions;
    (void)sd_fourier_init_f32(&self, &config, &tables);
}

int main(void) {
    ANY_BYTES(tables);
    //@ loop unroll 60;
    for (uint32_t positions = 12; positions <= SD_FOURIER_POSITIONS_MAX; positions += 12u) { call_all(positions); }
    return 0;
}
