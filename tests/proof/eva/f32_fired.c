/* SPDX-License-Identifier: MIT */
/* Learning of the tooth pattern while the engine fires, and of what looks like torque in it; any bits in state, sums, teeth and numbers of
 * the page, NaN included. 4 cylinders. */
/* options: -eva-precision 0 -eva-slevel 10 -eva-auto-loop-unroll 30 -eva-min-loop-unroll 9 -eva-plevel 300 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_fired.c firmware/torque/sd_hidden.c firmware/torque/sd_motion.c firmware/torque/sd_kalman_tables.c */
#include "f32_tables.h"
#include "sd_fired.h"

static sd_fired_t self;
static sd_fired_sums_t sums;
static sd_kalman_t kalman;
static float cycle_rad[2 * SD_KALMAN_POSITIONS_MAX];

static void fill(void) {
    ANY_BYTES(self), ANY_BYTES(sums), ANY_BYTES(kalman), ANY_BYTES(cycle_rad);
    kalman.believed = (uint8_t)any_upto(SD_KALMAN_SETS_MAX - 1u);
}

static void fill_phase(uint8_t phase) {
    fill();
    self.work.phase = phase;
    if (phase == (uint8_t)SD_FIRED_READS) { self.work.next = (uint8_t)any_upto(tables.hidden - 1u); } /* as each piece leaves it */
}

/* In each phase of the work on the last cycle. */
static void call_work(uint8_t phase, const sd_kalman_tooth_t *tooth, float any) {
    fill_phase(phase);
    (void)sd_fired_step(&self, &tables, &sums, cycle_rad, &kalman, tooth, any, any_bool(), any_bool());
    fill_phase(phase);
    (void)sd_fired_rest(&self, &tables, &sums, cycle_rad);
}

int main(void) {
    static const engine_t engine = { 60, 5, 4, 0, 12, 2, 1 };
    sd_kalman_tooth_t tooth;
    float any;
    any = any_number();
    ANY_BYTES(tooth);
    tooth.cycle_position = (uint16_t)any_upto(2u * engine.positions - 1u); /* sd_firings.c makes sure */
    fill_tables(&engine);
    for (uint8_t phase = 0; phase <= (uint8_t)SD_FIRED_PLACES; phase++) {
        tooth.advance = (uint16_t)(1u + any_upto(2u * engine.positions - 1u));
        call_work(phase, &tooth, any);
        tooth.advance = (uint16_t)(2u * engine.positions + 1u + any_upto(60000u));
        call_work(phase, &tooth, any);
    }
    fill();
    (void)sd_fired_sums_ok(&sums, &tables);
    sd_fired_resume(&self, &tables, &sums);
    sd_fired_init(&self);
    return 0;
}
