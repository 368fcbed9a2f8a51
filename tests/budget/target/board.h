/* SPDX-License-Identifier: MIT */
/// board.h - the emulated board, one of QEMU's mps2 family, and what the plugin is told.
#ifndef SD_BUDGET_BOARD_H
#define SD_BUDGET_BOARD_H
#include <stdint.h>

/// Where the emulator loads the calibration page, in ROM, and the events, in RAM that the image leaves free: a header, then
/// the events.
#define BOARD_PAGE   ((const uint8_t *)0x00200000u)
#define BOARD_EVENTS ((const void *)0x20200000u)

/// Before the events.
typedef struct board_header {
    uint32_t event_count, page_bytes, unused[2];
} board_header_t;

void board_print(const char *text);
void board_figure(const char *name, uint64_t value); ///< "NAME HEX".
void board_exit(uint32_t code);

/// What an event turned out to be; budget.toml has their names. A tooth is of the last class that fits.
enum {
    CLASS_OTHER, CLASS_REGULAR, CLASS_FIRING, CLASS_MARK, CLASS_MARK_FIRING, CLASS_CYCLE_END, CLASS_COASTED, CLASS_SPURIOUS,
    CLASS_SEARCHING, CLASS_STARTING, CLASS_CAM, CLASS_CLOCK, CLASS_LAMBDA, CLASS_SAMPLE, CLASS_SETUP, CLASS_COUNT
};

/// Classes that the plugin tells apart (CLASSES in plugin.c).
#define BUDGET_CLASSES 24u

/// Tells the plugin the class of what was executed since the last call, below BUDGET_CLASSES.
void budget_class(uint32_t event_class);

#endif
