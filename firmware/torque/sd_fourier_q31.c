/* SPDX-License-Identifier: MIT */
#define N q31
#define T sd_q31_t
#include "sd_fourier.inc"

_Static_assert(sizeof(sd_fourier_q31_t) == 264, "without pointers, the same size on every target");
