/* SPDX-License-Identifier: MIT */
/// sd_afr_inflow.h - what comes into the gas that the sensor meets within a wheel position, for those who mix it: the joint
/// filter and the model of the trims.
///
/// One cylinder after the other, x += share (a_i - x) gives x = (M x + sum D_i a_i)/(M + sum D_i), since what is mixed in first
/// is diluted by what follows. share is within [0, 1] whatever the numbers, so that the mixing is stable.
#ifndef SD_AFR_INFLOW_H
#define SD_AFR_INFLOW_H
#include "sd_exhaust.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What came to the sensor at a position.
typedef struct sd_afr_inflow {
    float   share[SD_AFR_CYLINDERS_MAX];    ///< Of the gas once it is in, (0, 1].
    uint8_t cylinder[SD_AFR_CYLINDERS_MAX]; ///< By firing order, ascending.
    uint8_t count;                          ///< How many cylinders' gas comes in.
} sd_afr_inflow_t;

/// From what the sensor meets.
void sd_afr_inflow_of(const sd_exhaust_now_f32_t *now, sd_afr_inflow_t *out);

#ifdef __cplusplus
}
#endif

#endif
