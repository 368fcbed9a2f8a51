/* SPDX-License-Identifier: MIT */
/* Every verb of q31 and every function of scaled numbers, for all arguments. */
#include "any_q31.h"

static volatile int64_t kept;

static void verbs(void) {
    const sd_q31_t a = any_q31(), b = any_q31(), c = any_q31(), d = any_q31();
    kept = sd_add_q31(a, b);
    kept = sd_sub_q31(a, b);
    kept = sd_mul_q31(a, b);
    kept = sd_abs_q31(a);
    kept = sd_neg_q31(a);
    kept = sd_gain_q31(any_gain(), a);
    kept = sd_signed_q31(any_of(0, INT32_MAX), a);
    kept = sd_shift_q31(a, any_of(0, 30));
    kept = sd_within_q31(a, any_of(0, INT32_MAX));
    kept = sd_ratio_q31(any_u32(), 1u + any_upto(UINT32_MAX - 1u));
    kept = sd_from_q31_q31(a);
    kept = sd_in_unit_q31(a);
    sd_pair_t p, q;
    p.half[0] = (int16_t)any_of(-32767, 32767), p.half[1] = (int16_t)any_of(-32767, 32767);
    q.half[0] = (int16_t)any_of(-32767, 32767), q.half[1] = (int16_t)any_of(-32767, 32767);
    kept = sd_dot_pair(p, q);
    /* A row whose values add up to no more than 2^31 - 1, as sd_row_fits_q31 wants it: the sizes share that. */
    sd_row_q31_t row;
    for (int i = 0; i < 4; ++i) { row.mantissa[i] = any_of(-(INT32_MAX / 4), INT32_MAX / 4); }
    kept = sd_row_q31(&row, a, b, c, d);
    for (int i = 0; i < 4; ++i) { row.mantissa[i] = any_q31(); }
    kept = sd_row_fits_q31(&row);
}

/* An accumulator in 2^30 terms: each adds less than 2^31 in size. */
static void sums(void) {
    const sd_acc_q31_t sum = (sd_acc_q31_t)any_q31() * (1 << 30);
    kept = sd_settle_q31(sd_mac_q31(sum, any_q31(), any_q31()));
    kept = sd_acc_q31(any_q31());
}

static void scaled(void) {
    const sd_scaled_t a = any_scaled(), b = any_scaled();
    kept = sd_scaled_add(a, b).mantissa;
    kept = sd_scaled_sub(a, b).mantissa;
    kept = sd_scaled_mul(a, b).mantissa;
    kept = sd_scaled_div(a, b).mantissa;
    kept = sd_scaled_less(a, b);
    kept = sd_scaled_root(a).mantissa;
    kept = sd_scaled_neg(a).mantissa;
    kept = sd_scaled_int(any_q31()).mantissa;
    kept = sd_scaled_q31(any_q31()).mantissa;
    kept = sd_scaled_to_q31(a);
    kept = sd_scaled_floor(a);
    kept = sd_scaled_fit(any_q31(), any_of(-64, 64));
    kept = sd_gain_scaled_q31(a).mantissa;
    kept = sd_bits_of(sd_scaled_to_float(a));
    kept = sd_bits_of(sd_float_int(any_q31()));
    kept = sd_bits_of(sd_float_q31(any_q31()));
}

static void floats(void) {
    const float x = any_float(-3.0e38f, 3.0e38f), low = any_float(-3.0e38f, 3.0e38f), high = any_float(-3.0e38f, 3.0e38f);
    kept = sd_scaled_of(x).mantissa;
    kept = sd_q31_by_integers(x);
    kept = sd_gain_of_q31(x).mantissa;
    kept = sd_bits_within(x, low, high) + sd_bits_above_to(x, low, high) + sd_bits_between(x, low, high);
}

int main(void) {
    verbs();
    sums();
    scaled();
    floats();
    return 0;
}
