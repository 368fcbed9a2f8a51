/* SPDX-License-Identifier: MIT */
#include "sd_page.h"

#include <string.h>

#include "sd_signals.h"

enum { HEADER_BYTES = 12, CHECKSUM_BYTES = 4 };

static void walk_bits(sd_page_walk_t *walk, uint32_t *bits, uint32_t count) {
    if (walk->to == NULL) { *bits = 0u; }
    for (uint32_t i = 0; i < count; ++i, ++walk->at) {
        if (walk->to != NULL) {
            walk->to[walk->at] = (uint8_t)(*bits >> (8u * i));
        } else if (walk->at < walk->size) { /* beyond the end: zeros, and the page is not complete */
            *bits |= (uint32_t)walk->from[walk->at] << (8u * i);
        }
    }
}

void sd_page_u8(sd_page_walk_t *walk, uint8_t *value) {
    uint32_t bits = *value;
    walk_bits(walk, &bits, 1u);
    if (walk->to == NULL) { *value = (uint8_t)bits; }
}

void sd_page_u16(sd_page_walk_t *walk, uint16_t *value) {
    uint32_t bits = *value;
    walk_bits(walk, &bits, 2u);
    if (walk->to == NULL) { *value = (uint16_t)bits; }
}

void sd_page_32(sd_page_walk_t *walk, void *value) {
    uint32_t bits;
    memcpy(&bits, value, sizeof bits);
    walk_bits(walk, &bits, 4u);
    if (walk->to == NULL) { memcpy(value, &bits, sizeof bits); }
}

/* CRC-32 of IEEE 802.3, bit by bit: a page is read once. */
static uint32_t checksum(const uint8_t *bytes, uint32_t size) {
    uint32_t crc = 0xffffffffu;
    for (uint32_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        for (uint32_t bit = 0; bit < 8u; ++bit) { crc = (crc >> 1) ^ ((crc & 1u) ? 0xedb88320u : 0u); }
    }
    return ~crc;
}

static void walk_header(sd_page_walk_t *walk, uint32_t header[3]) {
    walk->at = 0;
    for (uint32_t i = 0; i < 3u; ++i) { sd_page_32(walk, &header[i]); }
}

sd_page_walk_t sd_page_write(uint8_t *bytes) { return (sd_page_walk_t){ .to = bytes, .at = HEADER_BYTES }; }

uint32_t sd_page_seal(sd_page_walk_t *walk, uint32_t magic) {
    const uint32_t end = walk->at;
    uint32_t header[3] = { magic, end + CHECKSUM_BYTES, SD_SIGNALS_SIGNATURE };
    walk_header(walk, header);
    uint32_t crc = checksum(walk->to, end);
    walk->at = end;
    sd_page_32(walk, &crc);
    return walk->at;
}

sd_page_walk_t sd_page_read(const uint8_t *bytes, uint32_t size) {
    return (sd_page_walk_t){ .from = bytes, .size = size };
}

bool sd_page_sealed(sd_page_walk_t *walk, uint32_t magic) {
    if (walk->size < HEADER_BYTES + CHECKSUM_BYTES) { return false; }
    uint32_t header[3], crc = 0u;
    walk_header(walk, header);
    if ((header[0] != magic) || (header[1] != walk->size) || (header[2] != SD_SIGNALS_SIGNATURE)) { return false; }
    walk->at = walk->size - CHECKSUM_BYTES;
    sd_page_32(walk, &crc);
    walk->at = HEADER_BYTES;
    return crc == checksum(walk->from, walk->size - CHECKSUM_BYTES);
}

bool sd_page_complete(const sd_page_walk_t *walk) { return walk->at + CHECKSUM_BYTES == walk->size; }
