/* SPDX-License-Identifier: MIT */
/// sd_scaled.h - numbers of any size in integers, for what fixed point does once a cycle or at init: what a float of the page, of a
/// parameter or of an event means, and what is said as one. No function here uses floating-point arithmetic, so that a core
/// without such a unit needs no library for it; a float is only carried, and its IEEE 754 bits are read.
///
/// A scaled number is a mantissa of 31 bits and an exponent. Every result is rounded down to 31 bits; a conversion to a float
/// rounds to the nearest, ties to even. There is no overflow: exponents have room for every product of floats. Not a number
/// and infinite come out as 0: ranges are checked before (sd_bits_within).
#ifndef SD_SCALED_H
#define SD_SCALED_H
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A number: mantissa times a power of two.
typedef struct sd_scaled {
    int32_t mantissa; ///< 0, or 2^30 to 2^31 in size.
    int32_t exponent; ///< value = mantissa 2^(exponent - 31).
} sd_scaled_t;

/// The bits of a float, and the float of bits.
static inline uint32_t sd_bits_of(float x) {
    union { float f; uint32_t u; } both;
    both.f = x;
    return both.u;
}
static inline float sd_of_bits(uint32_t bits) {
    union { uint32_t u; float f; } both;
    both.u = bits;
    return both.f;
}

/* ---- floats in order, by their bits ------------------------------------------------------------------------------- */

/// A number that is ordered as the floats are; both zeros give 0. Not for NaN.
static inline int32_t sd_bits_order(float x) {
    const uint32_t u = sd_bits_of(x), size = u & 0x7fffffffu;
    return ((u >> 31) != 0u) ? -(int32_t)size : (int32_t)size;
}
static inline bool sd_bits_nan(float x) { return (sd_bits_of(x) & 0x7fffffffu) > 0x7f800000u; }
/// low <= x <= high, false for NaN.
static inline bool sd_bits_within(float x, float low, float high) {
    return !sd_bits_nan(x) && (sd_bits_order(x) >= sd_bits_order(low)) && (sd_bits_order(x) <= sd_bits_order(high));
}
/// above < x <= to, false for NaN.
static inline bool sd_bits_above_to(float x, float above, float to) {
    return !sd_bits_nan(x) && (sd_bits_order(x) > sd_bits_order(above)) && (sd_bits_order(x) <= sd_bits_order(to));
}
/// above < x < below, false for NaN.
static inline bool sd_bits_between(float x, float above, float below) {
    return !sd_bits_nan(x) && (sd_bits_order(x) > sd_bits_order(above)) && (sd_bits_order(x) < sd_bits_order(below));
}

/* ---- making one ----------------------------------------------------------------------------------------------------- */

#define SD_SCALED_ZERO ((sd_scaled_t){ 0, 0 }) ///< The number 0.

/// m 2^exponent for any whole m.
static inline sd_scaled_t sd_scaled_make(int64_t m, int32_t exponent) {
    if (m == 0) { return SD_SCALED_ZERO; }
    const uint64_t size = (m < 0) ? 0u - (uint64_t)m : (uint64_t)m;
    const uint32_t high = (uint32_t)(size >> 32);
    const int32_t bits = (high != 0u) ? 64 - __builtin_clz(high) : 32 - __builtin_clz((uint32_t)size);
    /* To 31 bits; -2^31 would be a mantissa too, but is kept out so that all sizes have one sign-free form. */
    const uint32_t to = (bits > 31) ? (uint32_t)(size >> (bits - 31)) : (uint32_t)size << (31 - bits);
    return (sd_scaled_t){ (m < 0) ? -(int32_t)to : (int32_t)to, exponent + bits };
}
/* The same of 32 bits, which need no wide shifts. */
static inline sd_scaled_t sd_scaled_narrow(int32_t m, int32_t exponent) {
    const uint32_t size = (m < 0) ? 0u - (uint32_t)m : (uint32_t)m;
    if (size == 0u) { return SD_SCALED_ZERO; }
    const int32_t left = __builtin_clz(size) - 1; /* -1 for -2^31 alone */
    const int32_t to = (int32_t)((left < 0) ? size >> 1 : size << left);
    return (sd_scaled_t){ (m < 0) ? -to : to, exponent + 31 - left };
}
static inline sd_scaled_t sd_scaled_int(int32_t x)  { return sd_scaled_narrow(x, 0); }
static inline sd_scaled_t sd_scaled_q31(int32_t x)  { return sd_scaled_narrow(x, -31); }

/// The number that a float is. Not for NaN.
static inline sd_scaled_t sd_scaled_of(float x) {
    const uint32_t u = sd_bits_of(x), e = (u >> 23) & 0xffu;
    if ((e == 0u) || (e == 255u)) { return SD_SCALED_ZERO; } /* zero and what is next to it */
    const int32_t m = (int32_t)(((u & 0x7fffffu) | 0x800000u) << 7);
    return (sd_scaled_t){ ((u >> 31) != 0u) ? -m : m, (int32_t)e - 126 };
}

/* ---- arithmetic ----------------------------------------------------------------------------------------------------- */

/// Opposite, size of the mantissa, sum, difference, and whether one is below another.
static inline sd_scaled_t sd_scaled_neg(sd_scaled_t a) { return (sd_scaled_t){ -a.mantissa, a.exponent }; }

static inline uint32_t sd_scaled_size(sd_scaled_t a) { return (uint32_t)((a.mantissa < 0) ? -a.mantissa : a.mantissa); }

/* The product of two such mantissas has 61 or 62 bits. */
static inline sd_scaled_t sd_scaled_mul(sd_scaled_t a, sd_scaled_t b) {
    const uint32_t high = (uint32_t)(((uint64_t)sd_scaled_size(a) * sd_scaled_size(b)) >> 30);
    const int32_t two = (high >= 0x80000000u) ? 1 : 0, to = (int32_t)(high >> two);
    if (to == 0) { return SD_SCALED_ZERO; }
    return (sd_scaled_t){ ((a.mantissa ^ b.mantissa) < 0) ? -to : to, a.exponent + b.exponent - 1 + two };
}

/// b is not 0 (else 0).
static inline sd_scaled_t sd_scaled_div(sd_scaled_t a, sd_scaled_t b) {
    if (b.mantissa == 0) { return SD_SCALED_ZERO; }
    /* 15, 12 and 12 bits of the quotient, by divisions of 32 bits: a core has no wider one. Each is at most 3 too small, which
     * the next one makes up for. */
    const uint32_t d = sd_scaled_size(b), part = (d >> 15) + 1u, first = sd_scaled_size(a) / part;
    uint64_t rest = ((uint64_t)sd_scaled_size(a) << 15) - (uint64_t)first * d;
    const uint32_t second = (uint32_t)(rest >> 3) / part;
    rest = (rest << 12) - (uint64_t)second * d;
    const uint32_t third = (uint32_t)(rest >> 3) / part;
    const int64_t quotient = (int64_t)(((uint64_t)first << 24) + ((uint64_t)second << 12) + third);
    return sd_scaled_make(((a.mantissa ^ b.mantissa) < 0) ? -quotient : quotient, a.exponent - b.exponent - 39);
}

static inline sd_scaled_t sd_scaled_add(sd_scaled_t a, sd_scaled_t b) {
    if (a.mantissa == 0) { return b; }
    if (b.mantissa == 0) { return a; }
    const sd_scaled_t large = (a.exponent >= b.exponent) ? a : b, small = (a.exponent >= b.exponent) ? b : a;
    const int32_t apart = large.exponent - small.exponent;
    if ((apart < 0) || (apart > 31)) { return large; } /* it never is below 0 */
    return sd_scaled_make((int64_t)large.mantissa * ((int64_t)1 << 31) + (((int64_t)small.mantissa * ((int64_t)1 << 31)) >> apart),
                          large.exponent - 62);
}
static inline sd_scaled_t sd_scaled_sub(sd_scaled_t a, sd_scaled_t b) { return sd_scaled_add(a, sd_scaled_neg(b)); }
static inline bool sd_scaled_less(sd_scaled_t a, sd_scaled_t b) { return sd_scaled_sub(a, b).mantissa < 0; }

/// Square root; 0 of what is not above 0.
static inline sd_scaled_t sd_scaled_root(sd_scaled_t a) {
    if (a.mantissa <= 0) { return SD_SCALED_ZERO; }
    const bool odd = (a.exponent & 1) != 0;
    uint64_t rest = (uint64_t)a.mantissa << (odd ? 30 : 31), root = 0; /* bit by bit, 31 of them */
    for (int32_t bit = 30; bit >= 0; --bit) {
        const uint64_t with = root | ((uint64_t)1 << bit), square = with * with;
        if (square <= rest) { root = with; }
    }
    return sd_scaled_make((int64_t)root, (a.exponent + (odd ? 1 : 0)) / 2 - 31);
}

/* ---- what becomes of it --------------------------------------------------------------------------------------------- */

/// m 2^-shift, rounded down, saturated to 32 bits.
static inline int32_t sd_scaled_fit(int32_t m, int32_t left) {
    if (left <= 0) { return (left > -32) ? m >> -left : ((m < 0) ? -1 : 0); }
    if (m == 0) { return 0; }
    return (m < 0) ? INT32_MIN : INT32_MAX;
}
/// Per unit, saturated.
static inline int32_t sd_scaled_to_q31(sd_scaled_t a) { return sd_scaled_fit(a.mantissa, a.exponent); }
/// The whole number at or below it; 0 below 0, saturated.
static inline uint32_t sd_scaled_floor(sd_scaled_t a) {
    const int32_t whole = sd_scaled_fit(a.mantissa, a.exponent - 31);
    return (whole > 0) ? (uint32_t)whole : 0u;
}
/// To the nearest float, ties to even; what is too small for one is 0.
static inline float sd_scaled_to_float(sd_scaled_t a) {
    if (a.mantissa == 0) { return 0.0f; }
    const uint32_t sign = (a.mantissa < 0) ? 0x80000000u : 0u, size = (uint32_t)((a.mantissa < 0) ? -a.mantissa : a.mantissa);
    uint32_t m = size >> 7;
    const uint32_t rest = size & 0x7fu;
    if ((rest > 64u) || ((rest == 64u) && ((m & 1u) != 0u))) { m++; } /* to 2^24, it runs into the exponent as it should */
    const int32_t e = a.exponent + 126;
    if (e <= 0) { return 0.0f; }
    if ((e > 254) || ((e == 254) && (m > 0xffffffu))) { return sd_of_bits(sign | 0x7f7fffffu); }
    return sd_of_bits(sign | (((uint32_t)e << 23) + (m - 0x800000u)));
}
/// A whole number as a float, and a share of one in q31.
static inline float sd_float_int(int32_t x) { return sd_scaled_to_float(sd_scaled_int(x)); }
static inline float sd_float_q31(int32_t x) { return sd_scaled_to_float(sd_scaled_q31(x)); }

#ifdef __cplusplus
}
#endif

#endif
