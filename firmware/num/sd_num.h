/* SPDX-License-Identifier: MIT */
/// sd_num.h - one arithmetic vocabulary, two number types: f32 (float) and q31 (1.31 fixed point).
///
/// A kernel body is written once against these verbs (sd_add, sd_mul, sd_gain ...) and compiled once per type; see
/// sd_fourier.inc. All values are per-unit in [-1, 1); q31 verbs saturate at the ends and round down. A gain is a
/// constant factor of any size up to 2^20; sums of products go through an accumulator that cannot overflow in 2^30 terms.
#ifndef SD_NUM_H
#define SD_NUM_H
#include <stdbool.h>
#include <stdint.h>

#include "sd_scaled.h"
#ifdef __ARM_FEATURE_DSP
#include <arm_acle.h>
#endif
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t sd_q31_t; /* LSB 4.66e-10 per unit */
#ifndef __cplusplus
_Static_assert((-1 >> 1) == -1, "q31 needs an arithmetic right shift");
#endif

/// A constant factor, and below it the same in q31.
typedef struct { float factor; } sd_gain_f32_t;
typedef struct { sd_q31_t mantissa; int32_t exponent; } sd_gain_q31_t; /* value = mantissa 2^(exponent - 31) */
/// A row of a matrix, and below it the same in q31.
typedef struct { float factor[4]; } sd_row_f32_t;
typedef struct { sd_q31_t mantissa[4]; } sd_row_q31_t;                   /* value = mantissa 2^(SD_ROW_BITS - 31) */
typedef float   sd_acc_f32_t;
typedef int64_t sd_acc_q31_t;

/// x cut to what 31 bits hold.
static inline sd_q31_t sd_sat_q31(int64_t x) {
    const int32_t low = (int32_t)(uint32_t)x, high = (int32_t)(x >> 32);
    return (high == (low >> 31)) ? low : (high >> 31) ^ INT32_MAX;
}

/* Saturating sums, one instruction where the core has it. */
#ifdef __ARM_FEATURE_DSP
static inline sd_q31_t sd_add_q31(sd_q31_t a, sd_q31_t b) { return __qadd(a, b); }
static inline sd_q31_t sd_sub_q31(sd_q31_t a, sd_q31_t b) { return __qsub(a, b); }
#else
static inline sd_q31_t sd_add_q31(sd_q31_t a, sd_q31_t b) {
    sd_q31_t sum;
    return __builtin_add_overflow(a, b, &sum) ? (a >> 31) ^ INT32_MAX : sum;
}
static inline sd_q31_t sd_sub_q31(sd_q31_t a, sd_q31_t b) {
    sd_q31_t difference;
    return __builtin_sub_overflow(a, b, &difference) ? (a >> 31) ^ INT32_MAX : difference;
}
#endif

/* a[0] b[0] + a[1] b[1] of two halves each, |sum| < 2^31; sum + that: one instruction where the core has it. */
typedef union { int16_t half[2]; int32_t word; } sd_pair_t;
#ifdef __ARM_FEATURE_SIMD32
static inline int32_t sd_dot_pair(sd_pair_t a, sd_pair_t b) { return __smuad(a.word, b.word); }
static inline int64_t sd_dot_pairs(int64_t sum, sd_pair_t a, sd_pair_t b) { return __smlald(a.word, b.word, sum); }
#else
static inline int32_t sd_dot_pair(sd_pair_t a, sd_pair_t b) { return a.half[0] * b.half[0] + a.half[1] * b.half[1]; }
static inline int64_t sd_dot_pairs(int64_t sum, sd_pair_t a, sd_pair_t b) {
    return sum + (int64_t)(a.half[0] * b.half[0]) + (int64_t)(a.half[1] * b.half[1]);
}
#endif

/* x / 2^31 rounded down, |x| <= 2^62: only 2^62 itself saturates, and does so by doubling its upper half. */
static inline sd_q31_t sd_high_q31(int64_t x) {
    const int32_t high = (int32_t)(x >> 32);
    return sd_add_q31(high, high) | (sd_q31_t)((uint32_t)x >> 31);
}

/// Sum, difference, product, size and opposite; a factor times a value. q31 saturates and rounds down.
static inline float    sd_add_f32(float a, float b)       { return a + b; }
static inline float    sd_sub_f32(float a, float b)       { return a - b; }
static inline float    sd_mul_f32(float a, float b)       { return a * b; }
static inline sd_q31_t sd_mul_q31(sd_q31_t a, sd_q31_t b) { return sd_high_q31((int64_t)a * b); }
static inline float    sd_abs_f32(float a)                { return __builtin_fabsf(a); }
static inline sd_q31_t sd_abs_q31(sd_q31_t a)             { return (a >= 0) ? a : sd_sub_q31(0, a); }
static inline float    sd_neg_f32(float a)                { return -a; }
static inline sd_q31_t sd_neg_q31(sd_q31_t a)             { return sd_sub_q31(0, a); }

/* numerator / denominator, both > 0; q31 saturates just below 1. */
static inline float    sd_ratio_f32(uint32_t n, uint32_t d) { return (float)n / (float)d; }
static inline sd_q31_t sd_ratio_q31(uint32_t n, uint32_t d) {
    return (n >= d) ? INT32_MAX : (sd_q31_t)(((uint64_t)n << 31) / d);
}

static inline float    sd_gain_f32(sd_gain_f32_t g, float x)    { return g.factor * x; }
static inline sd_q31_t sd_gain_q31(sd_gain_q31_t g, sd_q31_t x) {
    if (g.exponent <= 0) { return sd_mul_q31(g.mantissa, x) >> -g.exponent; } /* cannot leave the range: no 64 bits to shift */
    return sd_sat_q31(((int64_t)g.mantissa * x) >> (31 - g.exponent));
}

/* One row of a matrix, up to four columns: sums of products with one rounding at the end. Its values add up to less than
 * 2^SD_ROW_BITS, signs left out, so no sum of products overflows; see sd_row_fits_q31. */
#define SD_ROW_BITS 3
static inline float sd_row_f32(const sd_row_f32_t *row, float a, float b, float c, float d) {
    return (row->factor[0] * a + row->factor[1] * b) + (row->factor[2] * c + row->factor[3] * d);
}
static inline sd_q31_t sd_row_q31(const sd_row_q31_t *row, sd_q31_t a, sd_q31_t b, sd_q31_t c, sd_q31_t d) {
    const sd_q31_t *m = row->mantissa;
    return sd_sat_q31(((int64_t)m[0] * a + (int64_t)m[1] * b + (int64_t)m[2] * c + (int64_t)m[3] * d) >> (31 - SD_ROW_BITS));
}
static inline bool sd_row_fits_f32(const sd_row_f32_t *row) {
    float sum = 0.0f;
    for (int i = 0; i < 4; ++i) { sum += __builtin_fabsf(row->factor[i]); }
    return sum < (float)(1 << SD_ROW_BITS); /* false for NaN */
}
static inline bool sd_row_fits_q31(const sd_row_q31_t *row) {
    int64_t sum = 0;
    for (int i = 0; i < 4; ++i) { sum += (row->mantissa[i] < 0) ? -(int64_t)row->mantissa[i] : row->mantissa[i]; }
    return sum <= INT32_MAX;
}

/* size with the sign of `like`; that of 0 is positive. */
static inline float    sd_signed_f32(float size, float like)       { return __builtin_copysignf(size, like); }
static inline sd_q31_t sd_signed_q31(sd_q31_t size, sd_q31_t like) { return (size ^ (like >> 31)) - (like >> 31); }

/* x / 2^n, q31 rounds down; 0 <= n < 31. */
static inline float    sd_shift_f32(float x, int n)    { return x * (1.0f / (float)(1u << n)); }
static inline sd_q31_t sd_shift_q31(sd_q31_t x, int n) { return x >> n; }

/* acc + a b */
static inline sd_acc_f32_t sd_mac_f32(sd_acc_f32_t acc, float a, float b)       { return acc + a * b; }
static inline sd_acc_q31_t sd_mac_q31(sd_acc_q31_t acc, sd_q31_t a, sd_q31_t b) { return acc + (((int64_t)a * b) >> 31); }
static inline sd_acc_f32_t sd_acc_f32(float x)                 { return x; }
static inline sd_acc_q31_t sd_acc_q31(sd_q31_t x)              { return x; }
static inline float        sd_settle_f32(sd_acc_f32_t acc)     { return acc; }
static inline sd_q31_t     sd_settle_q31(sd_acc_q31_t acc)     { return sd_sat_q31(acc); }

/* Inside [-limit, limit], limit >= 0. */
static inline float    sd_within_f32(float x, float limit)       { return (x < -limit) ? -limit : (x > limit) ? limit : x; }
static inline sd_q31_t sd_within_q31(sd_q31_t x, sd_q31_t limit) { return (x < -limit) ? -limit : (x > limit) ? limit : x; }

/* Conversions, for init and read only. Those of q31 give the same bits by integers, for cores without a floating-point unit, as
 * by such a unit: rounded towards 0 into q31 and saturated, to the nearest float out of it. */
#if defined(__arm__) && !defined(__ARM_FP)
#define SD_BY_INTEGERS 1
#else
#define SD_BY_INTEGERS 0
#endif
static inline float    sd_from_float_f32(float x)    { return x; }
static inline sd_q31_t sd_q31_by_integers(float x) {
    const sd_scaled_t a = sd_scaled_of(x);
    return (a.mantissa < 0) ? -sd_scaled_to_q31(sd_scaled_neg(a)) - ((a.exponent > 0) ? 1 : 0) : sd_scaled_to_q31(a);
}
static inline sd_q31_t sd_from_float_q31(float x)    {
    return SD_BY_INTEGERS ? sd_q31_by_integers(x) : sd_sat_q31((int64_t)(x * 2147483648.0f));
}
static inline float    sd_to_float_f32(float x)      { return x; }
static inline float    sd_to_float_q31(sd_q31_t x)   { return SD_BY_INTEGERS ? sd_float_q31(x) : (float)x * (1.0f / 2147483648.0f); }
static inline float    sd_from_q31_f32(sd_q31_t x)   { return (float)x * (1.0f / 2147483648.0f); }
static inline sd_q31_t sd_from_q31_q31(sd_q31_t x)   { return x; }

/* |value| < 2^20; what is below 2^-20 loses bits. */
static inline sd_gain_f32_t sd_gain_of_f32(float value) { return (sd_gain_f32_t){ value }; }
static inline sd_gain_q31_t sd_gain_scaled_q31(sd_scaled_t a) {
    if (a.exponent > 20) { return (sd_gain_q31_t){ (a.mantissa < 0) ? INT32_MIN : INT32_MAX, 20 }; }
    if (a.exponent < -20) { return (sd_gain_q31_t){ sd_scaled_fit(a.mantissa, a.exponent + 20), -20 }; }
    return (sd_gain_q31_t){ a.mantissa, a.exponent };
}
static inline sd_gain_q31_t sd_gain_of_q31(float value) { return sd_gain_scaled_q31(sd_scaled_of(value)); }

/* What a kernel does at init and once a cycle with numbers of any size: sd_real_N_t, in f32 floats, in q31 scaled integers. */
typedef float       sd_real_f32_t;
typedef sd_scaled_t sd_real_q31_t;
/// The same of numbers of any size, for what init works out: sd_real_f32_t is a float, sd_real_q31_t a scaled number (sd_scaled.h).
static inline float       sd_real_of_f32(float x)                          { return x; }
static inline sd_scaled_t sd_real_of_q31(float x)                          { return sd_scaled_of(x); }
static inline float       sd_real_int_f32(int32_t x)                      { return (float)x; }
static inline sd_scaled_t sd_real_int_q31(int32_t x)                      { return sd_scaled_int(x); }
static inline float       sd_real_from_f32(float x)                       { return x; } /* of the kernel's own type */
static inline sd_scaled_t sd_real_from_q31(sd_q31_t x)                    { return sd_scaled_q31(x); }
static inline float       sd_real_add_f32(float a, float b)               { return a + b; }
static inline sd_scaled_t sd_real_add_q31(sd_scaled_t a, sd_scaled_t b)   { return sd_scaled_add(a, b); }
static inline float       sd_real_sub_f32(float a, float b)               { return a - b; }
static inline sd_scaled_t sd_real_sub_q31(sd_scaled_t a, sd_scaled_t b)   { return sd_scaled_sub(a, b); }
static inline float       sd_real_mul_f32(float a, float b)               { return a * b; }
static inline sd_scaled_t sd_real_mul_q31(sd_scaled_t a, sd_scaled_t b)   { return sd_scaled_mul(a, b); }
static inline float       sd_real_div_f32(float a, float b)               { return a / b; }
static inline sd_scaled_t sd_real_div_q31(sd_scaled_t a, sd_scaled_t b)   { return sd_scaled_div(a, b); }
static inline bool        sd_real_less_f32(float a, float b)              { return a < b; }
static inline bool        sd_real_less_q31(sd_scaled_t a, sd_scaled_t b)  { return sd_scaled_less(a, b); }
static inline uint32_t    sd_real_floor_f32(float x) {
    return ((x > 0.0f) && (x < 2147483648.0f)) ? (uint32_t)x : (x > 0.0f) ? INT32_MAX : 0u;
}
static inline uint32_t    sd_real_floor_q31(sd_scaled_t x)                { return sd_scaled_floor(x); }
static inline float       sd_real_value_f32(float x)                      { return x; } /* into the kernel's own type */
static inline sd_q31_t    sd_real_value_q31(sd_scaled_t x)                { return sd_scaled_to_q31(x); }
static inline float       sd_real_float_f32(float x)                      { return x; }
static inline float       sd_real_float_q31(sd_scaled_t x)                { return sd_scaled_to_float(x); }
static inline sd_gain_f32_t sd_real_gain_f32(float x)                     { return (sd_gain_f32_t){ x }; }
static inline sd_gain_q31_t sd_real_gain_q31(sd_scaled_t x)               { return sd_gain_scaled_q31(x); }

/* The square root of a normal x > 0, rounded as IEEE 754 has it, so that a core with an instruction for it, one without and the
 * host say the same bits, and nobody needs a libm. By whole numbers, a bit of the result after the other: */
static inline float sd_sqrt_by_bits_f32(float x) {
    union { float f; int32_t i; } both = { x };
    const int32_t odd = (both.i >> 23) - 127;
    int32_t left = ((both.i & 0x7fffff) | 0x800000) << (1 + (odd & 1)), root = 0, sum = 0;
    for (int32_t bit = 0x1000000; bit != 0; bit >>= 1) {
        const int32_t next = sum + bit;
        if (next <= left) { sum = next + bit; left -= next; root += bit; }
        left += left;
    }
    root += (left != 0) ? root & 1 : 0; /* never a tie: no such root has 25 bits */
    both.i = (root >> 1) + 0x3f000000 + (int32_t)((uint32_t)(odd >> 1) << 23);
    return both.f;
}
#if defined(__arm__) && defined(__ARM_FP) && (__ARM_FP & 4)
static inline float sd_sqrt_f32(float x) { float root; __asm("vsqrt.f32 %0, %1" : "=t"(root) : "t"(x)); return root; }
#elif defined(__SSE2__)
static inline float sd_sqrt_f32(float x) { return _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))); }
#else
static inline float sd_sqrt_f32(float x) { return sd_sqrt_by_bits_f32(x); }
#endif

/* A row of four values as above. */
static inline sd_row_f32_t sd_row_of_f32(const float *value) { return (sd_row_f32_t){ { value[0], value[1], value[2], value[3] } }; }
static inline sd_row_q31_t sd_row_of_q31(const float *value) {
    sd_row_q31_t row;
    for (int i = 0; i < 4; ++i) { row.mantissa[i] = sd_from_float_q31(value[i] * (1.0f / (float)(1 << SD_ROW_BITS))); }
    return row;
}

/* Inside the range, not at its ends, where q31 saturates; false for NaN. */
static inline bool sd_in_unit_f32(float x)    { return __builtin_fabsf(x) < 1.0f; }
static inline bool sd_in_unit_q31(sd_q31_t x) { return (x > INT32_MIN) && (x < INT32_MAX); }

#ifdef __cplusplus
}
#endif

#endif
