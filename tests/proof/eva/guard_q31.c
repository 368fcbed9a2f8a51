/* SPDX-License-Identifier: MIT */
/* The driveline's guard filter in q31: any state, any tables that init takes, any tooth and edge of the wheels. */
/* kernel: firmware/driveline/sd_driveline_guard_q31.c firmware/driveline/sd_driveline_tables.c */
#include "any_q31.h"
#include "sd_driveline_guard.h"

static sd_driveline_guard_q31_t self;
static sd_driveline_tables_t tables;

static sd_q31_t any_size(void) { return any_of(0, INT32_MAX); }
/* One of two coefficients of a sum: an analysis by intervals needs a share for each. */
static sd_q31_t any_half(void) { return any_of(0, INT32_MAX / 2); }

static sd_driveline_model_q31_t any_model(void) {
    sd_driveline_model_q31_t m;
    ANY_BYTES(m);
    m.tick = any_u32() >> 1, m.tick_down = any_upto(63u);
    m.pitch_rad = any_size(), m.wheel_pitch_rad = any_size(), m.shortest_s = any_size(), m.per_inertia = any_size();
    m.per_vehicle = any_size(), m.kink_rad = any_size(), m.rolling_nm = any_size(), m.drag_nms2 = any_size();
    m.viscous_nms = any_half(), m.ratio = any_half(), m.soft_nmprad = any_half(), m.stiff_nmprad = any_half(), m.damping_nms = any_half();
    return m;
}

static void fill_state(void) {
    ANY_BYTES(self);
    for (uint32_t i = 0; i < SD_DRIVELINE_STATES; i++) { self.gain[i] = any_gain(); }
    self.gear = (uint8_t)any_upto(SD_DRIVELINE_GEARS_MAX);
    self.model = any_model();
}

static void fill_tables(void) {
    ANY_BYTES(tables);
    tables.gears = (uint8_t)any_upto(SD_DRIVELINE_GEARS_MAX);
}

int main(void) {
    sd_driveline_out_q31_t out;
    fill_tables();
    fill_state();
    const sd_driveline_tooth_q31_t tooth = { any_u32(), any_u16(), (uint8_t)any_upto(255u), (uint8_t)any_upto(255u),
                                             any_q31(), any_q31(), any_q31() };
    sd_driveline_guard_step_q31(&self, &tables, &tooth, &out);
    fill_state();
    sd_driveline_guard_wheel_q31(&self, &tables, any_u32(), any_u16());
    sd_driveline_guard_restart_q31(&self);
    (void)sd_driveline_guard_init_q31(&self, &tables);
    return 0;
}
