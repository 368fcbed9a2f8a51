/* SPDX-License-Identifier: MIT */
/* hash_outputs PAGE EVENTS: what an ecu says to a page and to events, all in this processor's byte order; prints "hash HEX" as
 * budget_input does on the host. EVENTS: a header of four words, whose first counts them, and the events. */
#include <stdio.h>
#include <stdlib.h>

#include "output_hash.h"
#include "sd_ecu.h"

static const sd_event_t *waiting;
static uint64_t hash = SD_OUTPUT_HASH_START;

static uint32_t receive(void *context, sd_event_t *events, uint32_t room) {
    (void)context, (void)room;
    if (waiting == NULL) { return 0u; }
    *events = *waiting;
    waiting = NULL;
    return 1u;
}

static uint32_t send(void *context, const sd_event_t *events, uint32_t count) {
    (void)context;
    for (uint32_t i = 0; i < count; i++) { hash = sd_output_hash(hash, &events[i]); }
    return count;
}

/* A whole file in memory, which ends with the program; NULL when it cannot be read. */
static void *whole(const char *path, uint32_t *bytes) {
    FILE *file = fopen(path, "rb");
    if (file == NULL) { return NULL; }
    (void)fseek(file, 0, SEEK_END);
    const long size = ftell(file);
    rewind(file);
    void *text = malloc((size_t)size + 1u);
    *bytes = (text == NULL) ? 0u : (uint32_t)fread(text, 1, (size_t)size, file);
    (void)fclose(file);
    return text;
}

int main(int count, char **arguments) {
    static sd_ecu_t ecu;
    uint32_t page_bytes = 0, event_bytes = 0;
    if (count != 3) { return fprintf(stderr, "usage: hash_outputs PAGE EVENTS\n"), 2; }
    const void *stored = whole(arguments[1], &page_bytes), *listed = whole(arguments[2], &event_bytes);
    const sd_calibration_t *page = (stored == NULL) ? NULL : sd_calibration_view(stored, page_bytes);
    if ((page == NULL) || (sd_ecu_init(&ecu, page) != SD_OK)) { return fprintf(stderr, "hash_outputs: the page was refused\n"), 2; }
    const uint32_t events = (listed == NULL) ? 0u : *(const uint32_t *)listed;
    if (event_bytes < 16u * (events + 1u)) { return fprintf(stderr, "hash_outputs: events are missing\n"), 2; }
    const sd_port_t port = { NULL, receive, send };
    for (uint32_t i = 0; i < events; i++) {
        waiting = (const sd_event_t *)listed + 1u + i; /* the header is as long as an event */
        (void)sd_ecu_run(&ecu, page, &port);
    }
    printf("hash %llx\n", (unsigned long long)hash);
    return 0;
}
