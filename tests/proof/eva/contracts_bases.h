/* SPDX-License-Identifier: MIT */
/// contracts_bases.h - what divisions and roots of sd_bases.h promise, for Frama-C. tests/proof/every_number.c tries sd_reciprocal and
/// sd_root_q31 with every argument; saturate.c proves that of sd_sat_q31 and
/// bases.c the other two from these.
#ifndef SD_PROOF_CONTRACTS_BASES_H
#define SD_PROOF_CONTRACTS_BASES_H
#include "any.h"
#include "sd_bases.h"

/*@ assigns \result \from x;
    ensures sign: (x >= 0 ==> \result >= 0) && (x < 0 ==> \result < 0); */
static inline sd_q31_t sd_sat_q31(int64_t x);

/*@ requires one: 1073741824 <= d <= 2147483647;
    assigns \result \from d;
    ensures one: 1073741823 <= \result <= 2147483647; */
static inline int32_t sd_reciprocal(uint32_t d);

/*@ requires down: 0 <= down <= 30;
    assigns \result \from a, b, down; */
static inline sd_q31_t sd_over_q31(sd_q31_t a, sd_q31_t b, int down);

/*@ requires down: 1 <= down <= 30;
    assigns \result \from x, down;
    ensures sign: \result > 0; */
static inline sd_q31_t sd_inverse_q31(sd_q31_t x, int down);

/*@ assigns \result \from x;
    ensures sign: \result >= 0; */
static inline sd_q31_t sd_root_q31(sd_q31_t x);

#endif
