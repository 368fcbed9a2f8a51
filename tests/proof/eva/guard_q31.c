/* SPDX-License-Identifier: MIT */
/* The driveline's guard filter in q31: any state, any tables that init takes, any tooth and edge of the wheels. */
/* options: -eva-precision 0 -eva-slevel 60 -eva-auto-loop-unroll 8 -eva-split-return auto */
/* specified: sd_sat_q31 sd_over_q31 */
/* include: contracts_bases.h */
/* kernel: firmware/driveline/sd_driveline_guard_q31.c firmware/driveline/sd_driveline_tables.c */
#include "any_q31.h"
#include "sd_driveline_guard.h"

static sd_driveline_guard_q31_t self;
static sd_driveline_tables_t tables;

static sd_q31_t any_size(void) { return any_of(0, INT32_MAX); }
/* Two coefficients of a sum, which together are below 1: one of them is below a half. Intervals do not hold the sum; they need not, since
 * 64 bits have room for twice as much. */
static void any_pair(bool first, sd_q31_t *a, sd_q31_t *b) {
    *a = any_of(0, first ? INT32_MAX / 2 : INT32_MAX);
    *b = any_of(0, first ? INT32_MAX : INT32_MAX / 2);
}

static sd_driveline_model_q31_t any_model(bool damped, bool geared) {
    sd_driveline_model_q31_t m;
    ANY_BYTES(m);
    m.tick = any_u32() >> 1, m.tick_down = any_upto(63u);
    m.pitch_rad = any_size(), m.wheel_pitch_rad = any_size(), m.shortest_s = any_size(), m.per_inertia = any_size();
    m.per_vehicle = any_size(), m.kink_rad = any_size(), m.rolling_nm = any_size(), m.drag_nms2 = any_size();
    any_pair(geared, &m.viscous_nms, &m.ratio);
    any_pair(damped, &m.soft_nmprad, &m.damping_nms);
    m.stiff_nmprad = any_of(0, damped ? INT32_MAX / 2 : INT32_MAX);
    return m;
}

static void fill_state(bool damped, bool geared) {
    ANY_BYTES(self);
    for (uint32_t i = 0; i < SD_DRIVELINE_STATES; i++) { self.gain[i] = any_gain(); }
    self.gear = (uint8_t)any_upto(SD_DRIVELINE_GEARS_MAX);
    self.model = any_model(damped, geared);
}

static void fill_tables(void) {
    ANY_BYTES(tables);
    tables.gears = (uint8_t)any_upto(SD_DRIVELINE_GEARS_MAX);
}

static void call_all(bool damped, bool geared) {
    sd_driveline_out_q31_t out;
    fill_state(damped, geared);
    const sd_driveline_tooth_q31_t tooth = { any_u32(), any_u16(), (uint8_t)any_upto(255u), (uint8_t)any_upto(255u),
                                             any_q31(), any_q31(), any_q31() };
    sd_driveline_guard_step_q31(&self, &tables, &tooth, &out);
    fill_state(damped, geared);
    sd_driveline_guard_wheel_q31(&self, &tables, any_u32(), any_u16());
}

int main(void) {
    fill_tables();
    call_all(false, false);
    call_all(false, true);
    call_all(true, false);
    call_all(true, true);
    sd_driveline_guard_restart_q31(&self);
    ANY_BYTES(tables); /* what a page may say before it is looked at */
    (void)sd_driveline_guard_init_q31(&self, &tables);
    return 0;
}
