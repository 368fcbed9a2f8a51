/* SPDX-License-Identifier: MIT */
#define N q31
#define T sd_q31_t
#include "sd_afr_chain.inc"
