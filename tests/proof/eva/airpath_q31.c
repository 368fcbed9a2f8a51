/* SPDX-License-Identifier: MIT */
/* The air path's diagnosis in q31: any state, any tables and thresholds in range, any measurements at all. */
/* specified: sd_sat_q31 sd_over_q31 sd_inverse_q31 sd_root_q31 */
/* options: -machdep gcc_x86_64 -eva-precision 0 -eva-slevel 40 -eva-min-loop-unroll 4 -eva-auto-loop-unroll 20 */
/* include: contracts_bases.h */
/* kernel: firmware/airpath/sd_airpath_q31.c */
#include "any_q31.h"
#include "sd_airpath_bank.h"

enum { WINDOW_MOST = 1000000 }; /* steps: sums of residuals and flows are of no more */

static sd_airpath_bank_q31_t self;
static sd_airpath_tables_q31_t tables;
static sd_airpath_out_q31_t out;

static void any_row_of(sd_q31_t *to, uint32_t count, int32_t share) {
    for (uint32_t i = 0; i < count; i++) { to[i] = any_of(-share, share); }
}
static void any_knots(sd_q31_t *to, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) { to[i] = any_of(0, INT32_MAX); }
}

static void fill_tables(void) {
    sd_airpath_model_q31_t *m = &tables.model;
    tables.present = any_upto(1u);
    tables.period_s = any_of(1, INT32_MAX), tables.emptying_low_ps = any_of(1, INT32_MAX), tables.emptying_high_ps = any_of(1, INT32_MAX);
    any_knots(tables.fault, SD_AIRPATH_RESIDUALS);
    m->kappa = any_of(0, INT32_MAX), m->air_kpapgk = any_of(0, INT32_MAX), m->egr_kpapgk = any_of(0, INT32_MAX);
    m->exhaust_kpapgk = any_of(0, INT32_MAX), m->exhaust_jpkgk = any_of(0, INT32_MAX), m->ambient_kpa = any_of(1, INT32_MAX);
    m->rpm_most = any_of(1, INT32_MAX);
    any_knots(m->emptying_ps, SD_AIRPATH_KNOTS), any_knots(m->egr_area_mm2, SD_AIRPATH_KNOTS);
    any_knots(m->turbine_area_mm2, SD_AIRPATH_KNOTS), any_knots(m->turbine_drop, SD_AIRPATH_DROP_KNOTS);
    for (uint32_t o = 0; o < SD_AIRPATH_OBSERVERS; o++) { /* of each sum its share */
        sd_nuio_table_q31_t *n = &tables.observer[o];
        any_row_of(&n->m[0][0], 16u, INT32_MAX / 4), any_row_of(&n->e[0][0], 8u, INT32_MAX / 2);
        any_row_of(&n->k[0][0], 8u, INT32_MAX / 4), any_row_of(&n->more[0][0], 8u, INT32_MAX / 4), any_row_of(n->gamma, 2u, INT32_MAX / 2);
    }
    any_row_of(&tables.cusum.weight[0][0], SD_CUSUM_HYPOTHESES_MAX * SD_CUSUM_RESIDUALS_MAX, INT32_MAX / SD_CUSUM_RESIDUALS_MAX);
    for (uint32_t l = 0; l < SD_CUSUM_HYPOTHESES_MAX; l++) {
        tables.cusum.offset[l] = any_of(1, INT32_MAX), tables.cusum.group[l] = (uint8_t)any_upto(7u);
    }
    tables.cusum.hypotheses = (uint8_t)any_of(1, SD_CUSUM_HYPOTHESES_MAX), tables.cusum.residuals = (uint8_t)SD_AIRPATH_RESIDUALS;
}

static void fill_state(void) {
    const int64_t most = (int64_t)WINDOW_MOST << 31;
    ANY_BYTES(self);
    for (uint32_t i = 0; i < SD_AIRPATH_RESIDUALS; i++) { self.offsets.sum[i] = Frama_C_long_long_interval(-most, most); }
    self.offsets.flow_sum = Frama_C_long_long_interval(0, most);
    for (uint32_t l = 0; l < SD_CUSUM_HYPOTHESES_MAX; l++) { self.cusum.g[l] = any_of(0, INT32_MAX); }
    self.phase = (uint8_t)any_upto(SD_AIRPATH_DECIDES);
}

static void check_state(void) {
    for (uint32_t l = 0; l < SD_CUSUM_HYPOTHESES_MAX; l++) {
        //@ assert sum: self.cusum.g[l] >= 0;
    }
    //@ assert phase: self.phase <= SD_AIRPATH_DECIDES;
}

int main(void) {
    sd_airpath_in_q31_t in;
    const sd_airpath_config_q31_t config = { any_u32(), any_upto(WINDOW_MOST), { any_of(1, INT32_MAX), any_of(1, INT32_MAX) } };
    fill_tables();
    (void)sd_airpath_tables_ok_q31(&tables);
    (void)sd_cusum_thresholds_ok_q31(&config.thresholds);
    fill_state();
    sd_airpath_hold_q31(&self, &tables, &config, &out);
    check_state();
    ANY_BYTES(in);
    sd_airpath_step_q31(&self, &tables, &config, &in, &out);
    check_state();
    sd_airpath_wait_q31(&self, &out);
    check_state();
    ANY_BYTES(tables); /* what a page may say before it is looked at */
    (void)sd_airpath_tables_ok_q31(&tables);
    return 0;
}
