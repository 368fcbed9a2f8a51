/* SPDX-License-Identifier: MIT */
/* Learning of the tooth pattern while the engine fires, and of what looks like torque in it: teeth, the three steps of the task, kept sums;
 * any bits in state, sums, filter and numbers of the page, NaN included. 4 cylinders. */
/* options: -eva-precision 0 -eva-slevel 10 -eva-auto-loop-unroll 30 -eva-min-loop-unroll 61 -eva-plevel 300 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_fired.c firmware/torque/sd_hidden.c firmware/torque/sd_kalman.c firmware/torque/sd_kalman_firing.c firmware/torque/sd_motion.c firmware/torque/sd_kalman_tables.c */
#include "f32_tables.h"
#include "sd_fired.h"

enum { LATE_MOST = 30001 }; /* 0.3 rad in units, which units_of keeps */

static sd_fired_t self;
static sd_fired_sums_t sums;
static sd_kalman_t kalman;

static void fill(void) {
    ANY_BYTES(self), ANY_BYTES(sums), ANY_BYTES(kalman);
    self.collects = (uint8_t)any_upto(1u), self.used = (uint8_t)any_upto(1u);
    kalman.believed = (uint8_t)any_upto(SD_KALMAN_SETS_MAX - 1u);
    for (uint32_t i = 0; i < 2u; i++) {
        //@ loop unroll 120;
        for (uint32_t k = 0; k < SD_KALMAN_POSITIONS_MAX; k++) {
            self.cycle[i].late[k].half[0] = (int16_t)any_of(-LATE_MOST, LATE_MOST);
            self.cycle[i].late[k].half[1] = (int16_t)any_of(-LATE_MOST, LATE_MOST);
        }
    }
}

static void check(void) {
    //@ assert places: self.collects <= 1 && self.used <= 1;
    for (uint32_t i = 0; i < 2u; i++) {
        for (uint32_t k = 0; k < SD_KALMAN_POSITIONS_MAX; k++) {
            //@ assert first: -LATE_MOST <= self.cycle[i].late[k].half[0] <= LATE_MOST;
            //@ assert second: -LATE_MOST <= self.cycle[i].late[k].half[1] <= LATE_MOST;
        }
    }
}

static void take(uint32_t cycle_position, float fuel_mg) {
    fill();
    sd_fired_step(&self, &tables, &kalman, cycle_position, fuel_mg, any_bool());
    check();
}

int main(void) {
    static const engine_t engine = { 60, 5, 4, 0, 12, 2, 1 };
    float any;
    any = any_number();
    fill_tables(&engine);
    take(any_upto(59u), any); /* in the first revolution, in the second, elsewhere */
    take(60u + any_upto(59u), any);
    take(120u + any_upto(UINT32_MAX - 120u), any);
    sd_fired_rest(&self, &kalman);
    fill();
    sd_fired_hand_over(&self);
    sd_fired_work(&self, &tables, &sums);
    (void)sd_fired_take_over(&self);
    check();
    fill();
    (void)sd_fired_sums_ok(&sums, &tables);
    sd_fired_resume(&self, &tables, &sums);
    sd_fired_init(&self);
    return 0;
}
