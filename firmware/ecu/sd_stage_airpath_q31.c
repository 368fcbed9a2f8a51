/* SPDX-License-Identifier: MIT */
#include "sd_stage_airpath.h"

/* Cylinders, 1 to 8, per unit of 8. */
static inline sd_q31_t sd_count_q31(uint8_t cylinders) { return (cylinders < 8u) ? cylinders * (1 << 28) : SD_ONE_q31; }

#define N q31
#define T sd_q31_t
#define OF_PAGE airpath_q31
#include "sd_stage_airpath.inc"
