/* SPDX-License-Identifier: MIT */
#include "sd_stage_airpath.h"

/* Cylinders, 1 to 8. */
static inline float sd_count_f32(uint8_t cylinders) { return (float)cylinders; }

#define N f32
#define T float
#define OF_PAGE airpath
#include "sd_stage_airpath.inc"
