/* SPDX-License-Identifier: MIT */
/// sd_bases.h - verbs for a kernel whose quantities have different bases, beside those of sd_num.h: products that move to another base,
/// sums of products with one rounding, quotients and roots. In f32 a quantity has its unit and no base, and the verbs are the plain
/// arithmetic; in q31 a quantity is per unit of a power of two of its unit, which the kernel names.
///
/// Quotients and roots of q31 are made of multiplications and one division of 32 bits, the same bits on every core: within 2e-9 of
/// their true value and two units of the last place.
#ifndef SD_BASES_H
#define SD_BASES_H
#include "sd_math.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A constant, known when this is compiled: in q31 per unit of 2^bits.
#define SD_CONSTANT_f32(x, bits) (x)
#define SD_CONSTANT_q31(x, bits) ((sd_q31_t)((double)(x) * (2147483648.0 / (double)(1u << (bits)))))
/// The same of a small one, in q31 per unit of 2^-bits.
#define SD_SMALL_f32(x, bits) (x)
#define SD_SMALL_q31(x, bits) ((sd_q31_t)((double)(x) * (2147483648.0 * (double)(1u << (bits)))))
/// 1, or what comes next to it.
#define SD_ONE_f32 1.0f
#define SD_ONE_q31 INT32_MAX

/* a b, in q31 2^up times as much, 0 <= up <= 30. */
static inline float    sd_times_f32(float a, float b, int up)       { (void)up; return a * b; }
static inline sd_q31_t sd_times_q31(sd_q31_t a, sd_q31_t b, int up) { return sd_sat_q31(((int64_t)a * b) >> (31 - up)); }

/* The same, in q31 to the nearest: for what is summed up over many steps. */
static inline float    sd_times_near_f32(float a, float b, int up)       { (void)up; return a * b; }
static inline sd_q31_t sd_times_near_q31(sd_q31_t a, sd_q31_t b, int up) {
    return sd_sat_q31(((int64_t)a * b + ((int64_t)1 << (30 - up))) >> (31 - up));
}
/* A float that is carried (of an input, of a parameter) as a quantity, and a quantity as one; in q31 per unit of 2^bits, by integers. */
static inline float       sd_given_f32(float x, int bits)    { (void)bits; return x; }
static inline sd_q31_t    sd_given_q31(float x, int bits)    {
    const sd_scaled_t a = sd_scaled_of(x);
    return sd_scaled_fit(a.mantissa, a.exponent - bits);
}
static inline float       sd_real_based_f32(float x, int bits)    { (void)bits; return x; }
static inline sd_scaled_t sd_real_based_q31(sd_q31_t x, int bits) { return sd_scaled_narrow(x, bits - 31); }
static inline float       sd_said_f32(float x, int bits)     { (void)bits; return x; }
static inline float       sd_said_q31(sd_q31_t x, int bits)  { return sd_scaled_to_float(sd_scaled_narrow(x, bits - 31)); }

/* x times a part of [0, 1): nothing that could leave the range. */
static inline float    sd_part_f32(float part, float x)       { return part * x; }
static inline sd_q31_t sd_part_q31(sd_q31_t part, sd_q31_t x) { return (sd_q31_t)(((int64_t)part * x) >> 31); }

/* Sums of products of coefficients and quantities, with one rounding at the end. In q31 a coefficient is per unit of 32 times what the
 * bases say, and those of a sum, signs left out, add up to less than that. */
#define SD_WIDE_BITS 5
/// A sum that one value of 31 bits has no room for; in f32 a value like any other.
typedef float   sd_wide_f32_t;
typedef int64_t sd_wide_q31_t; ///< The same in q31.
static inline float   sd_wide_of_f32(float x)                                     { return x; }
static inline int64_t sd_wide_of_q31(sd_q31_t x)                                  { return (int64_t)x * (1 << (31 - SD_WIDE_BITS)); }
static inline float   sd_wide_mul_f32(float coefficient, float x)                 { return coefficient * x; }
static inline int64_t sd_wide_mul_q31(sd_q31_t coefficient, sd_q31_t x)           { return (int64_t)coefficient * x; }
static inline float   sd_wide_mac_f32(float sum, float coefficient, float x)      { return sum + coefficient * x; }
static inline int64_t sd_wide_mac_q31(int64_t sum, sd_q31_t coefficient, sd_q31_t x) { return sum + (int64_t)coefficient * x; }
static inline float   sd_wide_less_f32(float sum, float coefficient, float x)     { return sum - coefficient * x; }
static inline int64_t sd_wide_less_q31(int64_t sum, sd_q31_t coefficient, sd_q31_t x) { return sum - (int64_t)coefficient * x; }
/* Of two sums at most, each of which fits. */
static inline float   sd_wide_add_f32(float a, float b)                           { return a + b; }
static inline int64_t sd_wide_add_q31(int64_t a, int64_t b)                       { return a + b; }
/* A coefficient that moves by a part of [0, 1) of another one, both of which fit into one sum. */
static inline float    sd_wide_moved_f32(float from, float part, float by)        { return from + part * by; }
static inline sd_q31_t sd_wide_moved_q31(sd_q31_t from, sd_q31_t part, sd_q31_t by) {
    return from + (sd_q31_t)(((int64_t)part * by) >> 32) * 2;
}
static inline float    sd_wide_end_f32(float sum)                                 { return sum; }
static inline sd_q31_t sd_wide_end_q31(int64_t sum)                               { return sd_sat_q31(sum >> (31 - SD_WIDE_BITS)); }
/* Whether `count` coefficients may stand in one sum. */
static inline bool sd_wide_fits_q31(const sd_q31_t *coefficient, uint32_t count) {
    int64_t sum = 0;
    for (uint32_t i = 0; i < count; ++i) { sum += (coefficient[i] < 0) ? -(int64_t)coefficient[i] : coefficient[i]; }
    return sum <= INT32_MAX;
}

/* 2^61 / d, below 2^31, for d of [2^30, 2^31): a division, and a step of Newton's. */
static inline int32_t sd_reciprocal(uint32_t d) {
    const uint32_t first = (0xffffffffu / ((d + 0x4000u) >> 15)) << 14;
    const int64_t error = (int64_t)((1ull << 61) - (uint64_t)first * d);
    return (int32_t)first + (int32_t)(((int64_t)(int32_t)(error >> 30) * (int32_t)first) >> 31);
}

/* a / b, in q31 2^-down times as much, 0 <= down <= 30; b > 0, else q31 is at the end of its range. */
static inline float    sd_over_f32(float a, float b, int down)       { (void)down; return a / b; }
static inline sd_q31_t sd_over_q31(sd_q31_t a, sd_q31_t b, int down) {
    if (b <= 0) { return (a < 0) ? INT32_MIN : (a > 0) ? INT32_MAX : 0; }
    const int32_t left = __builtin_clz((uint32_t)b) - 1;
    const int64_t product = (int64_t)a * sd_reciprocal((uint32_t)b << left);
    return sd_sat_q31(product >> (30 - left + down));
}

/* 1 / x, in q31 2^-down times as much, 1 <= down <= 30; x > 0, else q31 is at the end of its range. */
static inline float    sd_inverse_f32(float x, int down)       { (void)down; return 1.0f / x; }
static inline sd_q31_t sd_inverse_q31(sd_q31_t x, int down) {
    const int32_t left = (x > 0) ? __builtin_clz((uint32_t)x) - 1 : down;
    return (left < down) ? sd_reciprocal((uint32_t)x << left) >> (down - 1 - left) : INT32_MAX;
}

/* Square root; 0 of what is not above 0. In q31 Newton's steps to 1/sqrt from a table, and one to the root. */
static inline float    sd_root_f32(float x) { return sd_root(x); }
static inline sd_q31_t sd_root_q31(sd_q31_t x) {
    static const uint16_t seed[48] = { /* 2^14/sqrt of the middle of each 64th from 1/4 to 1 */
    32268u, 31332u, 30474u, 29682u, 28949u, 28268u, 27632u, 27038u, 26481u, 25956u, 25462u, 24994u,
    24552u, 24132u, 23733u, 23354u, 22992u, 22646u, 22315u, 21999u, 21695u, 21404u, 21124u, 20855u,
    20596u, 20346u, 20106u, 19873u, 19649u, 19431u, 19221u, 19018u, 18821u, 18630u, 18444u, 18264u,
    18090u, 17920u, 17755u, 17594u, 17438u, 17285u, 17137u, 16992u, 16851u, 16714u, 16579u, 16448u
    };
    if (x <= 0) { return 0; }
    const int32_t left = (__builtin_clz((uint32_t)x) - 1) & ~1;
    const uint32_t u = (uint32_t)x << left; /* [1/4, 1) of 2^31 */
    uint32_t y = (uint32_t)seed[(u >> 25) - 16u] << 16; /* 1/sqrt(u) over 2^-30 */
    for (uint32_t i = 0; i < 2u; ++i) {
        const uint32_t square = (uint32_t)(((uint64_t)y * y) >> 31), about_one = (uint32_t)(((uint64_t)u * square) >> 31);
        y = (uint32_t)(((uint64_t)y * (0x60000000u - about_one)) >> 30);
    }
    const uint32_t root = (uint32_t)(((uint64_t)u * y) >> 30);
    const int64_t rest = (int64_t)((uint64_t)u << 31) - (int64_t)((uint64_t)root * root);
    return sd_sat_q31((int64_t)root + (((int64_t)(int32_t)(rest >> 31) * (int32_t)(y >> 1)) >> 30)) >> (left / 2);
}

#ifdef __cplusplus
}
#endif

#endif
