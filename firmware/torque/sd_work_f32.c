/* SPDX-License-Identifier: MIT */
#include "sd_math.h"

#define N    f32
#define ROOT sd_root
#include "sd_work.inc"
