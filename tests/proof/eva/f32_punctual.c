/* SPDX-License-Identifier: MIT */
/* Even tooth periods: any period, advance, finite lateness and remainder, and every time that a tooth leaves. Eva keeps NaN in what two
 * comparisons have bounded, so a lateness that is no number is left to test_fourier. */
/* options: -eva-precision 2 -eva-slevel 40 */
/* kernel: firmware/torque/sd_punctual.c */
#include <float.h>
#include "any.h"
#include "sd_punctual.h"

enum { BEFORE_LEAST = -0x20000000, BEFORE_MOST = 0x10000000 };

static sd_punctual_t self;

int main(void) {
    self.late_ticks = any_of(BEFORE_LEAST, BEFORE_MOST);
    self.left_ticks = any_float(-0.5f, 0.5f);
    /* Before and behind its place are two cases, so that each has its own range. */
    const bool early = any_bool();
    const float late_rad = early ? any_float(-FLT_MAX, 0.0f) : any_float(0.0f, FLT_MAX);
    const uint32_t period = any_u32(), advance = any_u32();
    (void)sd_punctual_period(&self, period, advance, late_rad, 10.0f);
    /*@ check BEFORE_LEAST <= self.late_ticks <= BEFORE_MOST; */
    return 0;
}
