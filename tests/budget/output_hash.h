/* SPDX-License-Identifier: MIT */
/// output_hash.h - one number for all that an ecu said, made alike on host and target.
#ifndef SD_OUTPUT_HASH_H
#define SD_OUTPUT_HASH_H
#include "hal.h"

/// FNV-1a, 64 bits. Start with SD_OUTPUT_HASH_START.
#define SD_OUTPUT_HASH_START 14695981039346656037ull

static inline uint64_t sd_output_hash(uint64_t hash, const sd_event_t *event) {
    const uint32_t words[4] = { event->tick, event->kind | ((uint32_t)event->channel << 16), event->value, event->flags };
    for (int i = 0; i < 4; i++) { hash = (hash ^ words[i]) * 1099511628211ull; }
    return hash;
}

#endif
