/* SPDX-License-Identifier: MIT */
/// sd_balance_zero.h - what the torques of single cylinders are off by, learned while nothing burns.
///
/// Motored, all cylinders give the torque 0; what an estimate says beyond their mean is an error of what it believes of
/// compression and trapped mass. That grows with the pressure in the intake, so it is kept per bar of it: the mean over the
/// motored cycles, the last 64 of them once there are so many.
///
/// Float only, no heap, no I/O, no libm. One writer per state; all zeros is its start.
#ifndef SD_BALANCE_ZERO_H
#define SD_BALANCE_ZERO_H
#include "sd_balance_watch.h"

typedef struct sd_balance_zero {
    float    nm_per_bar[SD_BALANCE_CYLINDERS_MAX];
    uint16_t cycles;   ///< Learned from, up to 64.
    uint16_t motored;  ///< In a row until now; the estimate settles in the first ones.
} sd_balance_zero_t;

/// One cycle: torque of each cylinder, absolute intake pressure, motored: nothing was injected, speed is steady and the
/// estimate is valid. Numbers that are not finite, and pressures not above 0, count as not motored.
void sd_balance_zero_step(sd_balance_zero_t *self, const float *torque_nm, uint32_t cylinders, float intake_bar, bool motored);
/// To be taken off a cylinder's torque; 0 until something was learned.
float sd_balance_zero_nm(const sd_balance_zero_t *self, uint32_t cylinder, float intake_bar);

#endif
