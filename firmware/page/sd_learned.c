/* SPDX-License-Identifier: MIT */
#include "sd_learned.h"

#include <stddef.h>

#define MAGIC 0x354c4453u /* "SDL5" */

void sd_learned_make(sd_learned_t *learned, const sd_pattern_sums_t *sums) {
    learned->sums = *sums;
    sd_page_seal(&learned->head, MAGIC, (uint32_t)sizeof *learned);
}

const sd_pattern_sums_t *sd_learned_view(const void *bytes, uint32_t size) {
    const bool whole = (size == sizeof(sd_learned_t)) && sd_page_sealed(bytes, size, MAGIC);
    return whole ? &((const sd_learned_t *)bytes)->sums : NULL;
}
