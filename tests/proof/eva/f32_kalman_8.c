/* SPDX-License-Identifier: MIT */
/* The filters on tooth times with the tables of one engine: 8 cylinders, two modes of twist. */
/* options: -eva-precision 0 -eva-slevel 10 -eva-auto-loop-unroll 30 -eva-min-loop-unroll 9 -eva-plevel 300 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_kalman.c firmware/torque/sd_kalman_firing.c firmware/torque/sd_kalman_tables.c firmware/torque/sd_motion.c firmware/torque/sd_road.c */
#include "f32_kalman.h"

int main(void) {
    static const engine_t engine = { 60, 9, 8, 2, 10, 3, 0 };
    call_all(&engine);
    return 0;
}
