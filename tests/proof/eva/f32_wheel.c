/* SPDX-License-Identifier: MIT */
/* Document 000's observers in f32, alone and on the toothed wheel: any bits in state and tables, NaN included; any tooth and firing. */
/* options: -eva-slevel 100 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/misfire/sd_switched_f32.c firmware/misfire/sd_switched_wheel_f32.c */
#include "any.h"
#include "sd_switched_wheel.h"

static sd_wheel_f32_t self;
static sd_wheel_tables_t tables;

static void fill_tables(uint32_t positions) {
    ANY_BYTES(tables);
    tables.positions = (uint8_t)positions;
    tables.cylinders = (uint8_t)any_of(1, SD_CYLINDERS_MAX);
    tables.speed_shift = (uint8_t)any_of(0, 24);
}

static void fill_state(void) {
    ANY_BYTES(self);
    self.open = (uint8_t)any_of(0, SD_CYLINDERS_MAX);
    self.config.kind = (uint8_t)any_upto(SD_WHEEL_KINDS - 1u);
}

static void call_all(uint32_t positions) {
    sd_wheel_tooth_t tooth;
    sd_wheel_config_f32_t config;
    sd_wheel_verdict_f32_t verdict;
    float any;
    fill_tables(positions);
    fill_state();
    ANY_BYTES(tooth), ANY_BYTES(config);
    any = any_number();
    (void)sd_wheel_tooth_f32(&self, &tables, &tooth, any);
    fill_state();
    sd_wheel_judge_f32(&self, &tables, any_u32(), any_upto(255u), &verdict);
    (void)sd_wheel_configure_f32(&self, &config);
    (void)sd_wheel_init_f32(&self, &config, &tables);
    sd_wheel_restart_f32(&self);
}

int main(void) {
    for (uint32_t positions = 12; positions <= SD_WHEEL_POSITIONS_MAX; positions += 36u) { call_all(positions); } /* 12, 48, 84, 120 */
    return 0;
}
