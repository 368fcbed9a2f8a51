/* SPDX-License-Identifier: MIT */
#define N f32
#define T float
#include "sd_afr_chain.inc"
