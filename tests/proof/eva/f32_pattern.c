/* SPDX-License-Identifier: MIT */
/* Learning in fuel cut: tooth pattern, exponent, twist and zeros; any bits in state, sums, teeth and numbers of the page, NaN included. A
 * rigid engine of 4 cylinders, and one of 8 whose crank has two modes. */
/* options: -eva-precision 0 -eva-slevel 10 -eva-auto-loop-unroll 30 -eva-min-loop-unroll 9 -eva-plevel 300 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_pattern.c firmware/torque/sd_twist.c firmware/torque/sd_motion.c firmware/torque/sd_fired.c firmware/torque/sd_hidden.c firmware/torque/sd_kalman_tables.c */
#include "f32_tables.h"
#include "sd_pattern.h"

static sd_pattern_t self;
static sd_pattern_sums_t sums;
static float zero[SD_KALMAN_FIRINGS_MAX];

/* Teeth whose place and advance are those of the wheel, and others. */
static void call_step(bool placed, bool advances) {
    const uint32_t cycle = 2u * tables.positions;
    sd_kalman_tooth_t tooth;
    ANY_BYTES(tooth);
    tooth.cycle_position = (uint16_t)(placed ? any_upto(cycle - 1u) : cycle + any_upto(UINT16_MAX - cycle));
    tooth.advance = (uint16_t)(advances ? 1u + any_upto(cycle - 1u) : cycle + 1u + any_upto(UINT16_MAX - cycle - 1u));
    ANY_BYTES(self);
    (void)sd_pattern_step(&self, &tables, &tooth);
}

static void call_all(const engine_t *engine) {
    sd_firing_t firing;
    float any;
    any = any_number();
    ANY_BYTES(firing), ANY_BYTES(sums);
    fill_tables(engine);
    call_step(true, true);
    call_step(true, false);
    call_step(false, true);
    ANY_BYTES(self);
    (void)sd_pattern_rest(&self, &tables);
    (void)sd_pattern_take_zero(&self, &tables, &firing, any, any);
    sd_pattern_zeros(&self, &tables, zero);
    sd_pattern_keep(&self, &tables, &sums);
    ANY_BYTES(sums);
    (void)sd_pattern_resume(&self, &tables, &sums);
    sd_pattern_init(&self, &tables);
}

int main(void) {
    static const engine_t rigid = { 60, 5, 4, 0, 12, 2, 0 }, twists = { 60, 9, 8, 2, 10, 3, 0 };
    call_all(&rigid);
    call_all(&twists);
    return 0;
}
