/* SPDX-License-Identifier: MIT */
/// f32_kalman.h - the filters on tooth times and the choice between them: any bits in state and teeth, NaN included, calls of all that
/// they do.
#ifndef SD_PROOF_F32_KALMAN_H
#define SD_PROOF_F32_KALMAN_H
#include "f32_tables.h"
#include "sd_road.h"

static sd_kalman_t self;
static sd_road_t road;

static void fill_state(void) {
    ANY_BYTES(self);
    self.filters = (uint8_t)any_of(1, SD_KALMAN_SETS_MAX), self.believed = (uint8_t)any_upto(SD_KALMAN_SETS_MAX - 1u);
    for (uint32_t i = 0; i < SD_KALMAN_SETS_MAX; i++) {
        for (uint32_t j = 0; j < SD_KALMAN_FIRINGS_MAX; j++) {
            self.filter[i].kept[j] = (uint8_t)any_upto(SD_KALMAN_MEAN), self.filter[i].next[j] = (uint8_t)any_upto(SD_KALMAN_MEAN - 1);
        }
    }
}

static void call_all(const engine_t *engine) {
    fill_tables(engine);
    sd_kalman_tooth_t tooth;
    sd_firing_t firing[SD_KALMAN_SETS_MAX];
    sd_kalman_choice_t choice;
    ANY_BYTES(tooth), ANY_BYTES(firing), ANY_BYTES(choice);
    firing[0].index = (uint8_t)any_upto(SD_KALMAN_FIRINGS_MAX - 1u), firing[1].index = (uint8_t)any_upto(SD_KALMAN_FIRINGS_MAX - 1u);
    fill_state();
    (void)sd_kalman_step(&self, &tables, &tooth, firing);
    //@ assert index: firing[0].index < SD_KALMAN_FIRINGS_MAX && firing[1].index < SD_KALMAN_FIRINGS_MAX;
    fill_state();
    (void)sd_kalman_torque(&self, &tables, any_upto(SD_KALMAN_SETS_MAX - 1u), any_upto(2u * tables.positions - 1u));
    (void)sd_kalman_status(&self, &tables, any_upto(SD_KALMAN_SETS_MAX - 1u));
    fill_state();
    sd_kalman_set_free(&self);
    sd_kalman_restart(&self);
    (void)sd_kalman_init(&self, &tables, &choice, (uint8_t)any_upto(255u));
    ANY_BYTES(road), ANY_BYTES(firing);
    (void)sd_road_step(&road, &firing[0], &firing[1]);
    sd_road_restart(&road);
}

#endif
