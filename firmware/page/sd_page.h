/* SPDX-License-Identifier: MIT */
/// sd_page.h - the head and the seal of what is kept outside the firmware: calibration page and learned values.
///
/// A page is a plain struct without pointers that begins with this head. It is read where it lies, in flash or in a file
/// buffer, and never copied; so it must be aligned to 4 bytes and made in the byte order of its target. A page of the other
/// byte order shows another magic and is refused.
#ifndef SD_PAGE_H
#define SD_PAGE_H
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Begins every page.
typedef struct sd_page_head {
    uint32_t magic;     ///< Kind and format of the page; the last character counts formats.
    uint32_t bytes;     ///< Size of the whole page, this head included.
    uint32_t signature; ///< SD_SIGNALS_SIGNATURE of the firmware that the page was made for.
    uint32_t checksum;  ///< CRC-32 of IEEE 802.3 over all bytes behind the head.
} sd_page_head_t;

/// Fills the head of a page of `bytes` bytes (at least a head) that begins with *head.
void sd_page_seal(sd_page_head_t *head, uint32_t magic, uint32_t bytes);

/// True when `page` is aligned, `size` bytes long by its own head, of this kind and signature, and its checksum is right.
/// Never reads beyond `size`.
bool sd_page_sealed(const void *page, uint32_t size, uint32_t magic);

#ifdef __cplusplus
}
#endif
#endif
