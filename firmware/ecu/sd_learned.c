/* SPDX-License-Identifier: MIT */
#include "sd_learned.h"

#include <string.h>

#include "sd_page.h"

#define MAGIC 0x314c4453u /* "SDL1" */

_Static_assert(sizeof(sd_pattern_sums_t) + 16u <= SD_LEARNED_BYTES_MAX, "the page has room");

/* The sums are floats without gaps. */
static void walk_sums(sd_page_walk_t *walk, sd_pattern_sums_t *sums) {
    float *value = (float *)sums;
    for (uint32_t i = 0; i < sizeof *sums / sizeof *value; ++i) { sd_page_32(walk, &value[i]); }
}

uint32_t sd_learned_encode(const sd_pattern_sums_t *sums, uint8_t *bytes) {
    sd_page_walk_t walk = sd_page_write(bytes);
    sd_pattern_sums_t copy = *sums;
    walk_sums(&walk, &copy);
    return sd_page_seal(&walk, MAGIC);
}

sd_result_t sd_learned_decode(sd_pattern_sums_t *sums, const uint8_t *bytes, uint32_t size) {
    sd_page_walk_t walk = sd_page_read(bytes, size);
    sd_pattern_sums_t fresh;
    if (!sd_page_sealed(&walk, MAGIC)) { return SD_ERR_PAGE; }
    memset(&fresh, 0, sizeof fresh);
    walk_sums(&walk, &fresh);
    if (!sd_page_complete(&walk)) { return SD_ERR_PAGE; }
    *sums = fresh;
    return SD_OK;
}
