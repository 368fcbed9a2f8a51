/* SPDX-License-Identifier: MIT */
/// sd_learned.h - learned.bin: what the firmware found out about its engine, kept while it is off. Hashed into logs like
/// the calibration, but no part of it: it belongs to one wheel, not to a type of engine.
#ifndef SD_LEARNED_H
#define SD_LEARNED_H
#include "sd_page.h"
#include "sd_pattern.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sd_learned {
    sd_page_head_t    head;
    sd_pattern_sums_t sums;
} sd_learned_t;

/// Fills *learned, ready to be stored as it is.
void sd_learned_make(sd_learned_t *learned, const sd_pattern_sums_t *sums);

/// The sums in stored bytes, where they lie; NULL when they are no such page. Whether they fit the wheel, sd_pattern_resume
/// says.
const sd_pattern_sums_t *sd_learned_view(const void *bytes, uint32_t size);

#ifdef __cplusplus
}
#endif
#endif
