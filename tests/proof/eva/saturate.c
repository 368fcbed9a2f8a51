/* SPDX-License-Identifier: MIT */
/* The contract of sd_sat_q31 for every number: in pieces in which the lower half of the word has one sign. */
/* include: contracts_bases.h */
#include "any.h"
#include "contracts_bases.h"

static volatile int32_t kept;

int main(void) {
    const int64_t half = (int64_t)1 << 31;
    kept = sd_sat_q31(Frama_C_long_long_interval(0, half - 1));
    kept = sd_sat_q31(Frama_C_long_long_interval(-half, -1));
    kept = sd_sat_q31(Frama_C_long_long_interval(half, 2 * half - 1));
    kept = sd_sat_q31(Frama_C_long_long_interval(2 * half, INT64_MAX));
    kept = sd_sat_q31(Frama_C_long_long_interval(-2 * half, -half - 1));
    kept = sd_sat_q31(Frama_C_long_long_interval(INT64_MIN, -2 * half - 1));
    return 0;
}
