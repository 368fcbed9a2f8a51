/* SPDX-License-Identifier: MIT */
/// sd_afr_inflow.h - what comes into the gas that the sensor meets within a wheel position, for those who mix it: the joint
/// filter and the model of the trims.
///
/// x = kept x + per_mass sum D_i a_i is (M x + sum D_i a_i)/(M + sum D_i), with one division for all. kept and what comes in add
/// up to 1 whatever the mass, so that the mixing is stable.
#ifndef SD_AFR_INFLOW_H
#define SD_AFR_INFLOW_H
#include "sd_exhaust.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What came to the sensor at a position. Where nothing did, count is 0 and nothing else holds.
typedef struct sd_afr_inflow {
    float   added[SD_AFR_CYLINDERS_MAX];    ///< D of each cylinder whose gas comes in, per mass_base, (0, 1].
    float   per_mass;                       ///< 1/(M + sum D), of the gas once all is in, per mass_base; above 0.
    float   kept;                           ///< Share of what was there before, [0, 1).
    uint8_t cylinder[SD_AFR_CYLINDERS_MAX]; ///< By firing order, ascending.
    uint8_t count;                          ///< How many cylinders' gas comes in.
} sd_afr_inflow_t;

/// From what the sensor meets.
void sd_afr_inflow_of(const sd_exhaust_now_f32_t *now, sd_afr_inflow_t *out);

#ifdef __cplusplus
}
#endif

#endif
