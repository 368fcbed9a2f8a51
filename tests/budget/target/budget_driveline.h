/* SPDX-License-Identifier: MIT */
/// budget_driveline.h - steps of the driveline's observers, for budget_blocks.c.
#ifndef BUDGET_DRIVELINE_H
#define BUDGET_DRIVELINE_H
#include <stdint.h>

/// The classes that count nothing, the guard filter, the bank. 0, or 1 when a block was refused or did not run.
uint32_t count_driveline(uint32_t not_counted, uint32_t guard, uint32_t bank);

#endif
