/* SPDX-License-Identifier: MIT */
/// sd_page.h - bytes of fixed order for what is kept outside the firmware: calibration and learned values.
///
/// A page is: magic, size, signature of the signal table (32 bits each, little endian), fields, CRC-32. One walk over the
/// fields serves writing and reading, so that the two cannot disagree. Never reads or writes beyond the page.
#ifndef SD_PAGE_H
#define SD_PAGE_H
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sd_page_walk {
    uint8_t       *to;   ///< Where fields go; null while reading.
    const uint8_t *from;
    uint32_t       at, size; ///< size: bytes there are to read.
} sd_page_walk_t;

/// Begins a page at `bytes`, which has room for it.
sd_page_walk_t sd_page_write(uint8_t *bytes);
/// Ends it; returns its size.
uint32_t sd_page_seal(sd_page_walk_t *walk, uint32_t magic);

sd_page_walk_t sd_page_read(const uint8_t *bytes, uint32_t size);
/// Magic, size, signature and checksum are right; the walk stands at the first field then.
bool sd_page_sealed(sd_page_walk_t *walk, uint32_t magic);
/// The fields read ended where the checksum begins.
bool sd_page_complete(const sd_page_walk_t *walk);

void sd_page_u8(sd_page_walk_t *walk, uint8_t *value);
void sd_page_u16(sd_page_walk_t *walk, uint16_t *value);
/// int32_t, uint32_t and float, by their bits.
void sd_page_32(sd_page_walk_t *walk, void *value);

#ifdef __cplusplus
}
#endif

#endif
