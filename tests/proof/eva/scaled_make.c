/* SPDX-License-Identifier: MIT */
/* options: -eva-auto-loop-unroll 70 */
/* The contracts of sd_scaled_make and sd_scaled_narrow for every argument: sizes from a power of two to below the next one, one after the other. */
#include "any.h"
#include "contracts.h"

static volatile int32_t kept;

static void of_size(int32_t bit, int32_t exponent) {
    const uint64_t low = (uint64_t)1 << bit, more = low - 1u;
    const uint64_t size = low + ((uint64_t)any_upto((uint32_t)(more >> 32)) << 32) + any_upto((more > UINT32_MAX) ? UINT32_MAX : (uint32_t)more);
    kept = sd_scaled_make((int64_t)size, exponent).mantissa;
    kept = sd_scaled_make(-(int64_t)size, exponent).mantissa;
    if (bit > 30) { return; }
    const int32_t narrow = (1 << bit) + any_of(0, (1 << bit) - 1);
    kept = sd_scaled_narrow(narrow, exponent).mantissa;
    kept = sd_scaled_narrow(-narrow, exponent).mantissa;
}

int main(void) {
    for (int32_t exponent = -1000000; exponent <= 1000000; exponent += 500000) { /* it is only added to */
        for (int32_t bit = 0; bit < 63; bit++) { of_size(bit, exponent); }
        kept = sd_scaled_make(0, exponent).mantissa;
        kept = sd_scaled_make(INT64_MIN, exponent).mantissa;
        kept = sd_scaled_narrow(0, exponent).mantissa;
        kept = sd_scaled_narrow(INT32_MIN, exponent).mantissa;
    }
    return 0;
}
