/* SPDX-License-Identifier: MIT */
#include "sd_page.h"

#include "sd_signals.h"

/* Bit by bit: a page is checked once, and a table would cost a kilobyte of flash. */
static uint32_t checksum(const uint8_t *bytes, uint32_t size) {
    uint32_t crc = 0xffffffffu;
    for (uint32_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        for (uint32_t bit = 0; bit < 8u; ++bit) { crc = (crc >> 1) ^ ((crc & 1u) ? 0xedb88320u : 0u); }
    }
    return ~crc;
}

void sd_page_seal(sd_page_head_t *head, uint32_t magic, uint32_t bytes) {
    const uint8_t *body = (const uint8_t *)(head + 1);
    *head = (sd_page_head_t){ magic, bytes, SD_SIGNALS_SIGNATURE, checksum(body, bytes - (uint32_t)sizeof *head) };
}

bool sd_page_sealed(const void *page, uint32_t size, uint32_t magic) {
    const sd_page_head_t *head = (const sd_page_head_t *)page;
    if ((((uintptr_t)page & 3u) != 0u) || (size < sizeof *head)) { return false; }
    if ((head->magic != magic) || (head->bytes != size) || (head->signature != SD_SIGNALS_SIGNATURE)) { return false; }
    return head->checksum == checksum((const uint8_t *)(head + 1), size - (uint32_t)sizeof *head);
}
