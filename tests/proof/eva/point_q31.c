/* SPDX-License-Identifier: MIT */
/* The operating point in q31: any state in range, any grid, any conditions. */
/* kernel: firmware/afr/sd_afr_point_q31.c firmware/afr/sd_exhaust_q31.c */
#include "any_q31.h"
#include "sd_afr_point.h"

static sd_afr_point_q31_t self;
static sd_afr_grid_t grid;
static sd_uego_gains_t gains;

static void fill_state(uint32_t cycle) {
    ANY_BYTES(self);
    for (uint32_t i = 0; i < 3u; i++) { self.part[i] = any_q31(); }
    self.node[0] = (uint8_t)any_upto(SD_AFR_SPEEDS - 2u);
    self.node[1] = (uint8_t)any_upto(SD_AFR_PRESSURES - 2u);
    self.node[2] = (uint8_t)any_upto(SD_AFR_LAMBDAS - 2u);
    self.mean_lambda = any_scaled(), self.rate_hz = any_scaled(), self.z0_kg = any_scaled(), self.transport_kg = any_scaled();
    self.exhaust.cycle_positions = (uint16_t)cycle;
    self.exhaust.cylinders = (uint8_t)any_of(0, SD_AFR_CYLINDERS_MAX);
    self.exhaust.present = (uint8_t)any_upto(1u);
    self.exhaust.open[0] = (uint16_t)any_upto(SD_EXHAUST_OPEN), self.exhaust.open[1] = (uint16_t)any_upto(SD_EXHAUST_OPEN);
}

int main(void) {
    ANY_BYTES(grid);
    for (uint32_t cycle = 24; cycle <= SD_AFR_POSITIONS_MAX; cycle += 108u) { /* 24, 132, 240 */
        const sd_afr_conditions_t at = { any_float(-3e38f, 3e38f), any_float(-3e38f, 3e38f), any_float(-3e38f, 3e38f),
                                         any_float(-3e38f, 3e38f), any_float(-3e38f, 3e38f), any_float(-3e38f, 3e38f),
                                         any_float(-3e38f, 3e38f) };
        fill_state(cycle);
        (void)sd_afr_point_begin_q31(&self, &at, any_scaled());
        for (uint32_t piece = 0; piece <= SD_AFR_PIECES; piece++) {
            fill_state(cycle);
            self.piece = (uint8_t)piece;
            (void)sd_afr_point_work_q31(&self, &grid, any_float(-1.0f, 1.0f));
            //@ assert nodes: self.node[0] <= 2 && self.node[1] <= 1 && self.node[2] == 0;
        }
        fill_state(cycle);
        sd_afr_point_gains_q31(&self, &grid, &gains);
    }
    return 0;
}
