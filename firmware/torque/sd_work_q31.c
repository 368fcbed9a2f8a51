/* SPDX-License-Identifier: MIT */
#include "sd_bases.h"

/* sd_scaled_root finds 31 bits one by one, which is a third of all that is done here. */
static sd_scaled_t quick_root(sd_scaled_t a) {
    const int32_t odd = a.exponent & 1;
    return sd_scaled_narrow(sd_root_q31(a.mantissa >> odd), (a.exponent + odd) / 2 - 31);
}

#define N    q31
#define ROOT quick_root
#include "sd_work.inc"
