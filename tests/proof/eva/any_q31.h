/* SPDX-License-Identifier: MIT */
/// any_q31.h - gains and rows in their range, for the drivers of kernels.
#ifndef SD_PROOF_ANY_Q31_H
#define SD_PROOF_ANY_Q31_H
#include "any.h"
#include "contracts.h"
#include "sd_num.h"

/// Any gain that sd_gain_of_q31 or sd_gain_scaled_q31 can make.
static inline sd_gain_q31_t any_gain(void) { return (sd_gain_q31_t){ any_q31(), any_of(-20, 20) }; }
/// The same of no sign.
static inline sd_gain_q31_t any_size_gain(void) { return (sd_gain_q31_t){ any_of(0, INT32_MAX), any_of(-20, 20) }; }
/// A row whose sizes add up to no more than sd_row_fits_q31 allows: an analysis by intervals needs a share for each.
static inline sd_row_q31_t any_row(void) {
    sd_row_q31_t row;
    for (int i = 0; i < 4; ++i) { row.mantissa[i] = any_of(-(INT32_MAX / 4), INT32_MAX / 4); }
    return row;
}
/// Any scaled number: 0, or a mantissa of 31 bits.
static inline sd_scaled_t any_scaled(void) {
    const int32_t size = any_of(1 << 30, INT32_MAX), exponent = any_of(-512, 512), which = any_of(0, 2);
    if (which == 0) { return SD_SCALED_ZERO; }
    return (sd_scaled_t){ (which == 1) ? size : -size, exponent };
}
/// Any q31 of a sine table. INT32_MIN, which is one value of a circle, is a case of its own where it matters.
static inline sd_q31_t any_sine(void) { return any_of(-INT32_MAX, INT32_MAX); }

#endif
