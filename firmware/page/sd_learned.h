/* SPDX-License-Identifier: MIT */
/// sd_learned.h - learned.bin: what the firmware found out about its engine, kept while it is off. Hashed into logs like
/// the calibration, but no part of it: it belongs to one wheel and one lambda sensor, not to a type of engine.
#ifndef SD_LEARNED_H
#define SD_LEARNED_H
#include "sd_afr_delay.h"
#include "sd_page.h"
#include "sd_pattern.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_LEARNED_MAGIC 0x364c4453u ///< "SDL6"; SDL5 held no mixture.

/// All that is kept.
typedef struct sd_kept {
    sd_pattern_sums_t pattern; ///< Of the wheel, with the cylinders' zeros, exponent and frequency of twist.
    sd_afr_kept_t     mixture; ///< Delay and lags of the lambda sensor.
} sd_kept_t;

/// All that an ecu has learned, as it is kept while the engine is off.
typedef struct sd_learned {
    sd_page_head_t head;
    sd_kept_t      kept;
} sd_learned_t;

/// Fills *learned, ready to be stored as it is.
void sd_learned_make(sd_learned_t *learned, const sd_kept_t *kept);

/// What is kept in stored bytes, where it lies; NULL when they are no such page. Whether it fits the engine, sd_ecu_resume
/// says.
const sd_kept_t *sd_learned_view(const void *bytes, uint32_t size);

#ifdef __cplusplus
}
#endif
#endif
