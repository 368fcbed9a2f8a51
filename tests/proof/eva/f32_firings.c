/* SPDX-License-Identifier: MIT */
/* Single firings: what is asked of the filters, which one is believed, what is learned when; any bits in state, page and teeth, NaN
 * included. Filters and learning are what contracts_firings.h says of them. */
/* options: -eva-precision 0 -eva-slevel 40 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h contracts_firings.h */
/* kernel: firmware/torque/sd_firings.c firmware/torque/sd_twist.c firmware/torque/sd_motion.c */
#include "contracts_firings.h"

static sd_firings_t self;
static sd_kalman_tables_t tables;
static sd_pattern_sums_t sums;

static void fill(void) {
    ANY_BYTES(self), ANY_BYTES(tables);
    tables.positions = (uint8_t)any_of(12, SD_KALMAN_POSITIONS_MAX), tables.cylinders = (uint8_t)any_of(1, SD_KALMAN_FIRINGS_MAX);
    tables.firings = (uint8_t)any_upto(SD_KALMAN_FIRINGS_MAX), tables.modes = (uint8_t)any_upto(SD_KALMAN_MODES_MAX);
    tables.sets = (uint8_t)any_of(1, SD_KALMAN_SETS_MAX);
    self.kalman.believed = (uint8_t)any_upto(SD_KALMAN_SETS_MAX - 1u), self.fired.used = (uint8_t)any_upto(1u);
}

int main(void) {
    sd_firings_config_t config;
    sd_firings_tooth_t tooth;
    sd_firings_out_t out;
    ANY_BYTES(config), ANY_BYTES(tooth), ANY_BYTES(sums);
    fill();
    sd_firings_step(&self, &tables, &tooth, &out);
    //@ assert believed: self.kalman.believed < SD_KALMAN_SETS_MAX;
    fill();
    sd_firings_task_begin(&self);
    sd_firings_task_work(&self, &tables);
    (void)sd_firings_task_end(&self);
    fill();
    sd_firings_spurious(&self, &tables);
    (void)sd_firings_believed(&self);
    sd_firings_restart(&self);
    (void)sd_firings_configure(&self, &config, &tables);
    (void)sd_firings_resume(&self, &tables, &sums);
    sd_firings_keep(&self, &tables, &sums);
    (void)sd_firings_init(&self, &config, &tables);
    return 0;
}
