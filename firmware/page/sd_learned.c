/* SPDX-License-Identifier: MIT */
#include "sd_learned.h"

#include <stddef.h>

void sd_learned_make(sd_learned_t *learned, const sd_kept_t *kept) {
    learned->kept = *kept;
    sd_page_seal(&learned->head, SD_LEARNED_MAGIC, (uint32_t)sizeof *learned);
}

const sd_kept_t *sd_learned_view(const void *bytes, uint32_t size) {
    const bool whole = (size == sizeof(sd_learned_t)) && sd_page_sealed(bytes, size, SD_LEARNED_MAGIC);
    return whole ? &((const sd_learned_t *)bytes)->kept : NULL;
}
