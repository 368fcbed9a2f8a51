/* SPDX-License-Identifier: MIT */
/* Exhaust manifold and delay in f32: any bits in state, tables and inputs, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/afr/sd_exhaust_f32.c */
#include "any.h"
#include "sd_exhaust.h"

static sd_exhaust_f32_t self;
static float psi[SD_EXHAUST_PSI + 1], share[SD_EXHAUST_OPEN];

static void fill_state(void) {
    ANY_BYTES(self);
    self.wait = any_upto(SD_EXHAUST_RING - 2u);
    self.at = any_upto(SD_EXHAUST_RING - 1u);
    self.held = any_upto(SD_EXHAUST_RING - 2u);
    self.cycle_positions = (uint16_t)any_of(24, SD_AFR_POSITIONS_MAX);
    self.cylinders = (uint8_t)any_of(1, SD_AFR_CYLINDERS_MAX);
    self.open[0] = (uint16_t)any_upto(SD_EXHAUST_OPEN), self.open[1] = (uint16_t)any_upto(SD_EXHAUST_OPEN);
    self.present = (uint8_t)any_upto(1u);
}

int main(void) {
    sd_exhaust_now_f32_t now;
    sd_exhaust_point_t point;
    sd_exhaust_config_t config;
    float any;
    ANY_BYTES(psi), ANY_BYTES(share), ANY_BYTES(config);
    any = any_number();
    point = (sd_exhaust_point_t){ any_number(), any_number(), any_number(), any_number(), any_number(), any_number() };
    fill_state();
    sd_exhaust_step_f32(&self, psi, any_u32(), &now);
    sd_exhaust_measured_f32(&self, any);
    for (uint32_t first = 0; first <= SD_EXHAUST_OPEN; first += 8u) {
        fill_state();
        (void)sd_exhaust_shares_f32(&self, first, any_upto(SD_EXHAUST_OPEN - first), share);
    }
    fill_state();
    (void)sd_exhaust_set_f32(&self, &point, any);
    (void)sd_exhaust_check_f32(&config);
    (void)sd_exhaust_init_f32(&self, &config);
    return 0;
}
