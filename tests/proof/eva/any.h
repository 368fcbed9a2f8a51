/* SPDX-License-Identifier: MIT */
/// any.h - numbers that may be anything, for drivers that Frama-C analyses and nobody runs; and compiler builtins that it does not know.
#ifndef SD_PROOF_ANY_H
#define SD_PROOF_ANY_H
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include "__fc_builtin.h"

/// Any number of [low, high].
static inline int32_t any_of(int32_t low, int32_t high) { return Frama_C_interval(low, high); }
static inline uint32_t any_upto(uint32_t high) { return Frama_C_unsigned_int_interval(0u, high); }
static inline int32_t any_q31(void) { return Frama_C_interval(INT32_MIN, INT32_MAX); }
static inline uint32_t any_u32(void) { return Frama_C_unsigned_int_interval(0u, UINT32_MAX); }
static inline uint16_t any_u16(void) { return (uint16_t)any_upto(UINT16_MAX); }
static inline bool any_bool(void) { return any_of(0, 1) != 0; }
/// A float of [low, high].
static inline float any_float(float low, float high) { return Frama_C_float_interval(low, high); }

/// Any float at all, NaN and infinite included, as a result of arithmetic: comparisons narrow it, which bytes they do not.
static inline float any_number(void) {
    float x;
    Frama_C_make_unknown((char *)&x, sizeof x);
    return x + 0.0f;
}

/// Every byte of it may be anything.
#define ANY_BYTES(object) Frama_C_make_unknown((char *)&(object), sizeof(object))

/* Leading zeros of x > 0, for which alone the builtin is defined. As comparisons of x, so that in each case the analysis knows how large
 * x is. any_zero() has no definition, and Frama-C says so when it can be reached. */
int32_t any_zero(void);
#define __builtin_clz(x) \
    ((x) >= 0x80000000u ? 0 : (x) >= 0x40000000u ? 1 : (x) >= 0x20000000u ? 2 : (x) >= 0x10000000u ? 3 : \
     (x) >= 0x8000000u ? 4 : (x) >= 0x4000000u ? 5 : (x) >= 0x2000000u ? 6 : (x) >= 0x1000000u ? 7 : \
     (x) >= 0x800000u ? 8 : (x) >= 0x400000u ? 9 : (x) >= 0x200000u ? 10 : (x) >= 0x100000u ? 11 : \
     (x) >= 0x80000u ? 12 : (x) >= 0x40000u ? 13 : (x) >= 0x20000u ? 14 : (x) >= 0x10000u ? 15 : \
     (x) >= 0x8000u ? 16 : (x) >= 0x4000u ? 17 : (x) >= 0x2000u ? 18 : (x) >= 0x1000u ? 19 : \
     (x) >= 0x800u ? 20 : (x) >= 0x400u ? 21 : (x) >= 0x200u ? 22 : (x) >= 0x100u ? 23 : \
     (x) >= 0x80u ? 24 : (x) >= 0x40u ? 25 : (x) >= 0x20u ? 26 : (x) >= 0x10u ? 27 : \
     (x) >= 0x8u ? 28 : (x) >= 0x4u ? 29 : (x) >= 0x2u ? 30 : (x) >= 0x1u ? 31 : \
     any_zero())
#define __builtin_fabsf(x) (((x) < 0.0f) ? -(x) : (x))
static inline bool any_add_overflow(int32_t a, int32_t b, int32_t *sum) {
    const int64_t exact = (int64_t)a + b;
    if ((exact > INT32_MAX) || (exact < INT32_MIN)) { *sum = 0; return true; }
    *sum = (int32_t)exact;
    return false;
}
static inline bool any_sub_overflow(int32_t a, int32_t b, int32_t *difference) {
    const int64_t exact = (int64_t)a - b;
    if ((exact > INT32_MAX) || (exact < INT32_MIN)) { *difference = 0; return true; }
    *difference = (int32_t)exact;
    return false;
}
#define __builtin_add_overflow(a, b, to) any_add_overflow(a, b, to)
#define __builtin_sub_overflow(a, b, to) any_sub_overflow(a, b, to)
#define __builtin_copysignf(size, like) (((like) < 0.0f) ? -(size) : (size))

#endif
