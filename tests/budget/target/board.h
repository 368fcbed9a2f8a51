/* SPDX-License-Identifier: MIT */
/// board.h - what the plugin is told, beside the emulated board (hal/cortexm/sd_board.h).
#ifndef SD_BUDGET_BOARD_H
#define SD_BUDGET_BOARD_H
#include "sd_board.h"

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
