/* SPDX-License-Identifier: MIT */
/* The air path's diagnosis in f32: any bits in state, tables and measurements, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/airpath/sd_airpath_f32.c */
#include "any.h"
#include "sd_airpath_bank.h"

static sd_airpath_bank_f32_t self;
static sd_airpath_tables_f32_t tables;
static sd_airpath_out_f32_t out;

static void fill(void) {
    ANY_BYTES(self), ANY_BYTES(tables);
    tables.cusum.hypotheses = (uint8_t)any_of(1, SD_CUSUM_HYPOTHESES_MAX), tables.cusum.residuals = (uint8_t)SD_AIRPATH_RESIDUALS;
    for (uint32_t l = 0; l < SD_CUSUM_HYPOTHESES_MAX; l++) { tables.cusum.group[l] = (uint8_t)any_upto(7u); }
}

int main(void) {
    sd_airpath_in_f32_t in;
    sd_airpath_config_f32_t config;
    ANY_BYTES(in), ANY_BYTES(config);
    fill();
    sd_airpath_hold_f32(&self, &tables, &config, &out);
    fill();
    sd_airpath_step_f32(&self, &tables, &config, &in, &out);
    sd_airpath_wait_f32(&self, &out);
    (void)sd_cusum_thresholds_ok_f32(&config.thresholds);
    ANY_BYTES(tables);
    (void)sd_airpath_tables_ok_f32(&tables);
    return 0;
}
