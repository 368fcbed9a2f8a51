/* SPDX-License-Identifier: MIT */
/* every_number: three functions of sd_num.h and sd_bases.h with every argument that there is, under a sanitizer: what Frama-C's intervals
 * cannot show of Newton's steps, and take for granted (eva/contracts_bases.h). Some minutes. */
#include <stdio.h>

#include "sd_bases.h"

/* The hardware's, of this machine. */
static float usual_root(float x) { return __builtin_sqrtf(x); }

int main(void) {
    for (uint32_t d = 1u << 30; d < 1u << 31; d++) {
        const int32_t r = sd_reciprocal(d);
        if (r < (1 << 30) - 1) { return printf("sd_reciprocal(%u) = %d\n", d, r), 1; }
    }
    for (uint32_t x = 1; x < 1u << 31; x++) {
        const sd_q31_t root = sd_root_q31((sd_q31_t)x);
        /* within three units of the true root */
        const uint64_t exact = (uint64_t)x << 31, r = (uint64_t)(uint32_t)root;
        const bool right = (root > 3) && ((r - 3u) * (r - 3u) <= exact) && ((r + 3u) * (r + 3u) > exact);
        if (!right) { return printf("sd_root_q31(%u) = %d\n", x, root), 1; }
    }
    for (uint32_t bits = 0x00800000u; bits < 0x7f800000u; bits++) {
        const float x = sd_of_bits(bits);
        if (sd_bits_of(sd_sqrt_by_bits_f32(x)) != sd_bits_of(usual_root(x))) { return printf("sd_sqrt_by_bits_f32(%g)\n", (double)x), 1; }
    }
    return printf("every number: nothing is wrong\n"), 0;
}
