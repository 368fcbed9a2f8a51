/* SPDX-License-Identifier: MIT */
/* sd_fixed_parts.h - what the files of the ecu of fixed point share, beside sd_ecu_parts.h; no part of its interface. */
#ifndef SD_FIXED_PARTS_H
#define SD_FIXED_PARTS_H
#include "sd_ecu.h"

#ifdef __cplusplus
extern "C" {
#endif

/* sd_fixed_cycle.c: pieces of work, in their order. */
typedef enum sd_fixed_piece {
    SD_FIXED_CYLINDERS, /* torque of each cylinder from the harmonics, one a piece */
    SD_FIXED_MIXTURE,   /* mixture read, operating point noted */
    SD_FIXED_TRIMS,     /* trims moved and said */
    SD_FIXED_SAY,       /* the cycle's row of signals, in parts */
    SD_FIXED_POINT,     /* tables of the operating point, in parts */
    SD_FIXED_NONE,
} sd_fixed_piece_t;

/* Begins the work of a cycle that ended; what the last one left is done at once. */
void sd_fixed_begin_work(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_cycle_t *cycle);

/* sd_fixed_say.c: values of the stages into signals. */
void sd_fixed_say_torque(sd_publish_t *say, const sd_fourier_q31_t *torque);
void sd_fixed_say_verdict(sd_ecu_t *self, const sd_calibration_t *page, const sd_wheel_verdict_q31_t *verdict);
void sd_fixed_say_mixture(sd_ecu_t *self, const sd_calibration_t *page);
void sd_fixed_say_trims(sd_ecu_t *self, const sd_calibration_t *page);

#ifdef __cplusplus
}
#endif

#endif
