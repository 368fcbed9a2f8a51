/* SPDX-License-Identifier: MIT */
/// sd_driveline_damping.h - a torque that takes the swing out of the driveline: so much less from the engine as the shaft winds up faster.
///
///     wanted = -gain winding, within +-limit;   the request follows it by at most rate a second
/// It is a request beside what the driver wants, to be added to it by whoever commands the engine's torque. It is off unless enabled. Where
/// the estimate is anything but valid, it goes to 0 by at most drop a second, so that it does not end with a jerk of its own.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data. Call order: init; step with
/// each sd_driveline_guard_step_f32.
#ifndef SD_DRIVELINE_DAMPING_H
#define SD_DRIVELINE_DAMPING_H
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Choices, read at each step.
typedef struct sd_driveline_damping_config {
    float   gain_nms;  ///< Torque at the crank for a rate of torsion of 1 rad/s, [0, 1e4].
    float   limit_nm;  ///< Largest request either way, [0, 2000].
    float   rate_nmps; ///< Fastest change of the request, [0, 1e6].
    float   drop_nmps; ///< Fastest change to 0 once the estimate is not valid, [0, 1e6].
    uint8_t enabled;   ///< 0: the request is 0.
} sd_driveline_damping_config_t;

/// State: plain data, caller-owned.
typedef struct sd_driveline_damping {
    float request_nm; ///< At the crank, to be added to what the driver wants.
} sd_driveline_damping_t;

/// SD_OK and a request of 0; or SD_ERR_CONFIG with the state untouched: a field of *config is out of range.
sd_result_t sd_driveline_damping_init(sd_driveline_damping_t *self, const sd_driveline_damping_config_t *config);
/// A step of `step_s` seconds, [0, 1]; anything else counts as 0. health: sd_health_t of the estimate. Returns the request. A
/// rate of torsion that is no number counts as an estimate that is not valid.
float sd_driveline_damping_step(sd_driveline_damping_t *self, const sd_driveline_damping_config_t *config, float winding_radps,
                                uint8_t health, float step_s);

#ifdef __cplusplus
}
#endif
#endif
