/* SPDX-License-Identifier: MIT */
/* Every verb of sd_bases.h but sd_reciprocal and sd_root_q31: numbers of one count of leading zeros after the other. */
/* specified: sd_reciprocal sd_sat_q31 */
/* options: -eva-slevel 200 -eva-auto-loop-unroll 40 */
/* include: contracts_bases.h */
#include "any_q31.h"
#include "contracts_bases.h"

static volatile int32_t kept;

static void divide(sd_q31_t b) {
    for (int down = 0; down <= 30; down++) {
        kept = sd_over_q31(any_of(0, INT32_MAX), b, down);
        kept = sd_over_q31(any_of(INT32_MIN, -1), b, down);
        if (down > 0) { kept = sd_inverse_q31(b, down); }
    }
}

static void sums(void) {
    const int share = INT32_MAX / 4;
    int64_t sum = sd_wide_of_q31(any_q31());
    sum = sd_wide_mac_q31(sum, any_of(-share, share), any_q31());
    sum = sd_wide_less_q31(sum, any_of(-share, share), any_q31());
    kept = sd_wide_end_q31(sd_wide_add_q31(sum, sd_wide_mul_q31(any_of(-share, share), any_q31())));
    kept = sd_wide_moved_q31(any_of(-share, share), any_of(0, INT32_MAX), any_of(-share, share));
    const sd_q31_t any[4] = { any_q31(), any_q31(), any_q31(), any_q31() };
    kept = sd_wide_fits_q31(any, 4u);
}

int main(void) {
    divide(any_of(INT32_MIN, 0));
    for (int bit = 0; bit < 31; bit++) { divide((1 << bit) + any_of(0, (1 << bit) - 1)); }
    for (int up = 0; up <= 30; up++) { kept = sd_times_q31(any_q31(), any_q31(), up); }
    kept = sd_part_q31(any_q31(), any_q31());
    kept = sd_given_q31(any_float(-3.0e38f, 3.0e38f), any_of(-30, 30));
    (void)sd_real_based_q31(any_q31(), any_of(-30, 30));
    (void)sd_said_q31(any_q31(), any_of(-30, 30));
    sums();
    return 0;
}
