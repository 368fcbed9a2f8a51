/* SPDX-License-Identifier: MIT */
/// contracts_root.h - the root of a core without an instruction for it, for Frama-C: tests/proof/every_number.c tries it with every number.
#ifndef SD_PROOF_CONTRACTS_ROOT_H
#define SD_PROOF_CONTRACTS_ROOT_H
#include "any.h"
#include "sd_num.h"

/*@ assigns \result \from x; */
static inline float sd_sqrt_by_bits_f32(float x);

#endif
