/* SPDX-License-Identifier: MIT */
/// sd_learned.h - learned.bin: what the firmware found out about its engine, kept while it is off. Hashed into logs like
/// the calibration, but no part of it: it belongs to one wheel, not to a type of engine.
#ifndef SD_LEARNED_H
#define SD_LEARNED_H
#include "sd_pattern.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_LEARNED_BYTES_MAX 1280u

/// Writes the page to `bytes` (room for SD_LEARNED_BYTES_MAX); returns its size.
uint32_t sd_learned_encode(const sd_pattern_sums_t *sums, uint8_t *bytes);
/// SD_OK, or SD_ERR_PAGE with *sums untouched. Whether they fit the wheel, sd_pattern_resume says.
sd_result_t sd_learned_decode(sd_pattern_sums_t *sums, const uint8_t *bytes, uint32_t size);

#ifdef __cplusplus
}
#endif

#endif
