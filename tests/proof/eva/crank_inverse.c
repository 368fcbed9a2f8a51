/* SPDX-License-Identifier: MIT */
/* The contract of sd_inverse_of for every period: those of one number of leading zeros after the other. */
/* include: contracts_crank.h */
#include "sd_crank_parts.h"

static volatile int32_t kept;

int main(void) {
    for (int32_t bit = 5; bit < 29; bit++) {
        const int32_t low = 1 << bit;
        kept = sd_inverse_of(low + any_of(0, low - 1)).period;
    }
    kept = sd_inverse_of(any_of(INT32_MIN, 31)).period;
    kept = sd_inverse_of(any_of(1 << 29, INT32_MAX)).period;
    return 0;
}
