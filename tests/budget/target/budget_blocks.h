/* SPDX-License-Identifier: MIT */
/// budget_blocks.h - blocks that are stepped one at a time, in files of their own.
#ifndef SD_BUDGET_BLOCKS_H
#define SD_BUDGET_BLOCKS_H
#include <stdint.h>

/// The decoder on made edges. Classes from first_class on: regular tooth, fault (coasted to, or spurious), searching, the edge that
/// gives sync, of a wheel with one mark; then the same of one with four.
void budget_count_crank(uint32_t first_class);

/// The driveline's observers. The classes that count nothing, the guard filter, the bank. 0, or 1 when a block was refused or did not run.
uint32_t budget_count_driveline(uint32_t not_counted, uint32_t guard, uint32_t bank);

/// A step of the air path's diagnosis that decides. 0, or 1 when its tables were refused or it did not get to decide.
uint32_t budget_count_airpath(uint32_t not_counted, uint32_t step);

#endif
