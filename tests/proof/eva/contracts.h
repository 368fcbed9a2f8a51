/* SPDX-License-Identifier: MIT */
/// contracts.h - what sd_scaled_make and sd_scaled_narrow promise, for Frama-C. scaled_make.c proves it for every argument; elsewhere it
/// stands for their bodies, since an analysis by intervals cannot see that as many bits are shifted as there are.
#ifndef SD_PROOF_CONTRACTS_H
#define SD_PROOF_CONTRACTS_H
#include "sd_scaled.h"

/*@ requires place: -1000000 <= exponent <= 1000000;
    assigns \result \from m, exponent;
    ensures size: \result.mantissa == 0 || 1073741824 <= \result.mantissa <= 2147483647 || -2147483647 <= \result.mantissa <= -1073741824;
    ensures place: \result.exponent == 0 || exponent <= \result.exponent <= exponent + 64; */
static inline sd_scaled_t sd_scaled_make(int64_t m, int32_t exponent);

/*@ requires place: -1000000 <= exponent <= 1000000;
    assigns \result \from m, exponent;
    ensures size: \result.mantissa == 0 || 1073741824 <= \result.mantissa <= 2147483647 || -2147483647 <= \result.mantissa <= -1073741824;
    ensures place: \result.exponent == 0 || exponent <= \result.exponent <= exponent + 32; */
static inline sd_scaled_t sd_scaled_narrow(int32_t m, int32_t exponent);

#endif
