/* SPDX-License-Identifier: MIT */
/* Trims of the ecu of fixed point: any state, any estimate, parameters as the table has them and beyond. */
/* kernel: firmware/ecu_fixed/sd_fixed_trims.c */
#include "any_q31.h"
#include "sd_fixed_trims.h"

static sd_fixed_trims_t self;
static sd_parameters_t p;
static sd_afr_estimate_t estimate;

int main(void) {
    for (uint32_t cylinders = 1; cylinders <= SD_CYLINDERS_MAX; cylinders++) {
        ANY_BYTES(self);
        ANY_BYTES(p);
        ANY_BYTES(estimate);
        sd_fixed_trims_cycle(&self, &p, cylinders, (sd_trims_wish_t)any_upto(2u), &estimate, (uint8_t)any_upto(255u), any_bool());
        (void)sd_fixed_trims_status(&self);
        sd_fixed_trims_restart(&self);
    }
    return 0;
}
