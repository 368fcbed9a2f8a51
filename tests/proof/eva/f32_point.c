/* SPDX-License-Identifier: MIT */
/* The operating point in f32: any bits in state, grid and conditions, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/afr/sd_afr_point_f32.c firmware/afr/sd_exhaust_f32.c */
#include "any.h"
#include "sd_afr_point.h"

static sd_afr_point_f32_t self;
static sd_afr_grid_t grid;
static sd_uego_gains_t gains;

static void fill_state(void) {
    ANY_BYTES(self);
    self.node[0] = (uint8_t)any_upto(SD_AFR_SPEEDS - 2u);
    self.node[1] = (uint8_t)any_upto(SD_AFR_PRESSURES - 2u);
    self.node[2] = (uint8_t)any_upto(SD_AFR_LAMBDAS - 2u);
    self.exhaust.cycle_positions = (uint16_t)any_of(24, SD_AFR_POSITIONS_MAX);
    self.exhaust.cylinders = (uint8_t)any_of(0, SD_AFR_CYLINDERS_MAX);
    self.exhaust.present = (uint8_t)any_upto(1u);
    self.exhaust.open[0] = (uint16_t)any_upto(SD_EXHAUST_OPEN), self.exhaust.open[1] = (uint16_t)any_upto(SD_EXHAUST_OPEN);
}

int main(void) {
    sd_afr_conditions_t at;
    float any;
    ANY_BYTES(grid), ANY_BYTES(at);
    any = any_number();
    fill_state();
    (void)sd_afr_point_begin_f32(&self, &at, any);
    for (uint32_t piece = 0; piece <= SD_AFR_PIECES; piece++) {
        fill_state();
        self.piece = (uint8_t)piece;
        (void)sd_afr_point_work_f32(&self, &grid, any);
        //@ assert nodes: self.node[0] <= 2 && self.node[1] <= 1 && self.node[2] == 0;
    }
    fill_state();
    sd_afr_point_gains_f32(&self, &grid, &gains);
    return 0;
}
