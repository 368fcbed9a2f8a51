/* SPDX-License-Identifier: MIT */
/* The negative control: a kernel of the same kind with faults that the analysis must find. Sums of products in 64 bits that overflow
 * when every value is at its end, a shift by a gain's whole exponent, a table read one place too far. */
#include "any_q31.h"

static volatile int32_t kept;

static sd_q31_t dot_of_four(const sd_q31_t *a, const sd_q31_t *b) {
    int64_t sum = 0;
    for (int i = 0; i < 4; ++i) { sum += (int64_t)a[i] * b[i]; } /* no share for each: sd_row_q31 has one */
    return sd_sat_q31(sum >> 31);
}
static sd_q31_t gain_without_a_case(sd_gain_q31_t g, sd_q31_t x) { return sd_mul_q31(g.mantissa, x) << g.exponent; }

int main(void) {
    sd_q31_t a[4], b[4];
    for (int i = 0; i < 4; ++i) { a[i] = any_q31(), b[i] = any_q31(); }
    kept = dot_of_four(a, b);
    kept = gain_without_a_case(any_gain(), any_q31());
    kept = a[any_of(0, 4)];
    return 0;
}
