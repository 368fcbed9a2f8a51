/* SPDX-License-Identifier: MIT */
/* Manifold and delay in q31: any state in range, any operating point, position and pressure. */
/* kernel: firmware/afr/sd_exhaust_q31.c */
#include "any_q31.h"
#include "sd_exhaust.h"

static sd_exhaust_q31_t self;
static sd_q31_t psi[SD_EXHAUST_PSI + 1], share[SD_EXHAUST_OPEN];

static void fill_state(uint32_t cycle) {
    ANY_BYTES(self);
    self.delay = any_of(0, INT32_MAX), self.charge = any_of(0, INT32_MAX), self.late = any_of(0, INT32_MAX);
    self.wait = any_upto(SD_EXHAUST_RING - 2u);
    self.to_z = any_gain(), self.rate = any_gain(), self.of_pressure = any_gain();
    self.gain_mass = any_gain(), self.gain_outflow = any_gain(), self.to_positions = any_gain();
    self.at = any_upto(SD_EXHAUST_RING - 1u);
    self.held = any_upto(SD_EXHAUST_RING - 2u);
    self.cycle_positions = (uint16_t)cycle;
    self.cylinders = (uint8_t)any_of(1, SD_AFR_CYLINDERS_MAX);
    self.mass_base_kg = any_float(1e-6f, 1.0f);
    for (uint32_t i = 0; i < SD_AFR_CYLINDERS_MAX; i++) { self.open_at[i] = (uint16_t)any_upto(cycle - 1u); }
    self.open[0] = (uint16_t)any_upto(SD_EXHAUST_OPEN), self.open[1] = (uint16_t)any_upto(SD_EXHAUST_OPEN);
    self.present = (uint8_t)any_upto(1u);
}

static sd_exhaust_point_t any_point(void) {
    return (sd_exhaust_point_t){ any_float(-1e9f, 1e9f), any_float(-1e9f, 1e9f), any_float(-1e9f, 1e9f), any_float(-1e9f, 1e9f),
                                 any_float(-1e9f, 1e9f), any_float(-1e9f, 1e9f) };
}

int main(void) {
    for (uint32_t k = 0; k <= SD_EXHAUST_PSI; k++) { psi[k] = any_of(0, INT32_MAX); }
    for (uint32_t k = 0; k < SD_EXHAUST_OPEN; k++) { share[k] = any_q31(); }
    for (uint32_t cycle = 24; cycle <= SD_AFR_POSITIONS_MAX; cycle += 108u) { /* 24, 132, 240 */
        sd_exhaust_now_q31_t now;
        fill_state(cycle);
        sd_exhaust_step_q31(&self, psi, any_u32(), &now);
        sd_exhaust_measured_q31(&self, any_q31());
        for (uint32_t first = 0; first <= SD_EXHAUST_OPEN; first += 8u) { /* as pieces of an operating point begin */
            fill_state(cycle);
            (void)sd_exhaust_shares_q31(&self, first, any_upto(SD_EXHAUST_OPEN - first), share);
        }
        (void)sd_exhaust_shares_q31(&self, SD_EXHAUST_OPEN + 1u + any_upto(UINT32_MAX - SD_EXHAUST_OPEN - 1u), any_u32(), share);
        fill_state(cycle);
        const sd_exhaust_point_t point = any_point();
        (void)sd_exhaust_set_q31(&self, &point, any_float(-1.0f, 1.0f));
    }
    return 0;
}
