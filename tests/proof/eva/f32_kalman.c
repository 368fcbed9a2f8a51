/* SPDX-License-Identifier: MIT */
/* The filters on tooth times and the choice between them: any bits in state, numbers of the page and teeth, NaN included. Sizes of the page
 * are those of three engines: 4 cylinders; 8 with two modes of twist, at 12 speeds; 12 harmonics. */
/* options: -eva-precision 0 -eva-auto-loop-unroll 30 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_kalman.c firmware/torque/sd_kalman_firing.c firmware/torque/sd_kalman_tables.c firmware/torque/sd_motion.c firmware/torque/sd_road.c */
#include "any.h"
#include "sd_road.h"

static sd_kalman_t self;
static sd_kalman_tables_t tables;
static sd_road_t road;

static void fill_tables(uint32_t coefficients, uint32_t firings, uint32_t modes, uint32_t speeds, uint32_t window) {
    ANY_BYTES(tables);
    tables.positions = 60, tables.coefficients = (uint8_t)coefficients, tables.speeds = (uint8_t)speeds, tables.sets = 2;
    tables.firings = (uint8_t)firings, tables.cylinders = (uint8_t)((firings > 0u) ? firings : 4u), tables.modes = (uint8_t)modes;
    tables.shapes = (firings > 0u) ? 1 : 0, tables.window = (uint8_t)window, tables.teeth = 58;
    tables.gains_at = (uint16_t)sd_motion_gains_at(&tables), tables.row_words = (uint16_t)sd_motion_row_words(&tables);
}

static void fill_state(void) {
    ANY_BYTES(self);
    self.filters = (uint8_t)any_of(1, SD_KALMAN_SETS_MAX), self.believed = (uint8_t)any_upto(SD_KALMAN_SETS_MAX - 1u);
    for (uint32_t i = 0; i < SD_KALMAN_SETS_MAX; i++) {
        for (uint32_t j = 0; j < SD_KALMAN_FIRINGS_MAX; j++) {
            self.filter[i].kept[j] = (uint8_t)any_upto(SD_KALMAN_MEAN), self.filter[i].next[j] = (uint8_t)any_upto(SD_KALMAN_MEAN - 1);
        }
    }
}

static void call_all(void) {
    sd_kalman_tooth_t tooth;
    sd_firing_t firing[SD_KALMAN_SETS_MAX];
    sd_kalman_choice_t choice;
    ANY_BYTES(tooth), ANY_BYTES(firing), ANY_BYTES(choice);
    fill_state();
    (void)sd_kalman_step(&self, &tables, &tooth, firing);
    fill_state();
    (void)sd_kalman_torque(&self, &tables, any_upto(SD_KALMAN_SETS_MAX - 1u), any_upto(2u * tables.positions - 1u));
    (void)sd_kalman_status(&self, &tables, any_upto(SD_KALMAN_SETS_MAX - 1u));
    sd_kalman_restart(&self);
    (void)sd_kalman_tables_ok(&tables);
    (void)sd_kalman_init(&self, &tables, &choice, (uint8_t)any_upto(255u));
    ANY_BYTES(road), ANY_BYTES(firing);
    (void)sd_road_step(&road, &firing[0], &firing[1]);
    sd_road_restart(&road);
}

int main(void) {
    fill_tables(5, 4, 0, 12, 2);
    call_all();
    fill_tables(9, 8, 2, 12, 3);
    call_all();
    fill_tables(25, 0, 0, 4, 24);
    call_all();
    return 0;
}
