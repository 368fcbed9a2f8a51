/* SPDX-License-Identifier: MIT */
/// sd_airpath_point.h - whether the engine runs at one operating point, and whether it is still that where offsets were learned.
///
/// Document 001's model, equation (1), holds at rest: its temperatures come from sensors that lag, and what its parameters are off by
/// leaves other residuals at another point. So nothing is decided while speed or fuel are on their way, and offsets are learned anew at a
/// point far
/// from the last one.
///     calm: for calm_s, speed within 5 % and fuel within 10 % of what they are on average over mean_s
///     left: speed more than 12 % or fuel more than 25 % off the point that was kept
///
/// Two variants from one body; in q31 speeds are per unit of 2^15 rpm, flows of 2^16 g/s, the period of 2^-6 s.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers.
#ifndef SD_AIRPATH_POINT_H
#define SD_AIRPATH_POINT_H
#include "sd_bases.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_POINT_MEAN_S 1.5f ///< Time constant of the means, s.
#define SD_AIRPATH_POINT_CALM_S 3.0f ///< How long the point must have been calm, s.
#define SD_AIRPATH_PERIOD       6 ///< Base of a period in q31 is 2^-6 s.

/// State and functions of the point in one number type: N is f32 or q31, T its type.
#define SD_AIRPATH_POINT_DECLARE(N, T)                                                                                 \
    /* All zero is a valid start. */                                                                                   \
    typedef struct sd_airpath_point_##N {                                                                              \
        T        speed_rpm, fuel_gps;           /* On average; 0 before the first step. */                             \
        T        kept_speed_rpm, kept_fuel_gps; /* Where offsets were learned; 0: nowhere. */                          \
        uint32_t calm_steps;                    /* Steps since speed or fuel were last on their way, saturating. */    \
    } sd_airpath_point_##N##_t;                                                                                        \
    /* A period, (0, 0.1] s, with speed and fuel flow, each within [0, 1e6]. True when the engine is calm. */          \
    bool sd_airpath_point_step_##N(sd_airpath_point_##N##_t *self, T period, T speed_rpm, T fuel_gps);                 \
    /* Keeps the point on average now. */                                                                              \
    void sd_airpath_point_keep_##N(sd_airpath_point_##N##_t *self);                                                    \
    /* Whether it has left the one kept; false where none is. */                                                       \
    bool sd_airpath_point_left_##N(const sd_airpath_point_##N##_t *self);

SD_AIRPATH_POINT_DECLARE(f32, float)
SD_AIRPATH_POINT_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif
#endif
