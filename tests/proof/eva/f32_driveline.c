/* SPDX-License-Identifier: MIT */
/* The driveline's guard filter, document 003's observers and the damping: any bits in state, tables and inputs, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/driveline/sd_driveline_guard_f32.c firmware/driveline/sd_driveline_tables.c firmware/driveline/sd_driveline_hybrid.c firmware/driveline/sd_driveline_damping.c */
#include "any.h"
#include "sd_driveline_damping.h"
#include "sd_driveline_guard.h"
#include "sd_driveline_hybrid.h"

static sd_driveline_tables_t tables;
static sd_driveline_guard_f32_t guard;
static sd_driveline_hybrid_t hybrid;
static sd_driveline_damping_t damping;

static void fill_guard(void) {
    ANY_BYTES(tables), ANY_BYTES(guard);
    tables.gears = (uint8_t)any_of(0, SD_DRIVELINE_GEARS_MAX);
    guard.gear = (uint8_t)any_upto(SD_DRIVELINE_GEARS_MAX);
}

static void call_guard(void) {
    sd_driveline_tooth_f32_t tooth;
    sd_driveline_out_f32_t out;
    ANY_BYTES(tooth);
    fill_guard();
    sd_driveline_guard_step_f32(&guard, &tables, &tooth, &out);
    fill_guard();
    sd_driveline_guard_wheel_f32(&guard, &tables, any_u32(), any_u16());
    sd_driveline_guard_restart_f32(&guard);
    ANY_BYTES(tables);
    (void)sd_driveline_guard_init_f32(&guard, &tables);
}

static void call_rest(float any) {
    sd_driveline_hybrid_out_t out;
    sd_driveline_damping_config_t config;
    ANY_BYTES(hybrid), ANY_BYTES(damping), ANY_BYTES(config);
    hybrid.location = (uint8_t)any_of(1, SD_DRIVELINE_LOCATIONS);
    sd_driveline_hybrid_step(&hybrid, &tables.gear[0].bank, any, any, any, &out);
    (void)sd_driveline_hybrid_init(&hybrid, &tables.gear[0].bank, (uint8_t)any_upto(255u));
    (void)sd_driveline_damping_step(&damping, &config, any, (uint8_t)any_upto(255u), any);
    (void)sd_driveline_damping_init(&damping, &config);
}

int main(void) {
    float any;
    any = any_number();
    call_guard();
    call_rest(any);
    return 0;
}
