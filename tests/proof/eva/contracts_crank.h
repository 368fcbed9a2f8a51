/* SPDX-License-Identifier: MIT */
/// contracts_crank.h - what the decoder's division promises, for Frama-C. crank_inverse.c proves it for every period; elsewhere it stands
/// for the body, since an analysis by intervals cannot see that a number shifted by its leading zeros has its first bit set.
#ifndef SD_PROOF_CONTRACTS_CRANK_H
#define SD_PROOF_CONTRACTS_CRANK_H
#include "any.h"
#include "sd_crank_parts.h"

/*@ assigns \result \from foretold;
    ensures scale: 32768 <= \result.scale <= 65536;
    ensures shift: 0 <= \result.shift <= 23;
    ensures most: 255 <= \result.most <= 2147483647;
    ensures period: PERIOD_MIN / 2 <= \result.period <= PERIOD_MAX; */
SD_INLINE sd_inverse_t sd_inverse_of(int32_t foretold);

#endif
