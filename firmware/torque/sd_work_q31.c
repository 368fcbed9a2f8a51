/* SPDX-License-Identifier: MIT */
#include "sd_scaled.h"

#define N    q31
#define ROOT sd_scaled_root
#include "sd_work.inc"
