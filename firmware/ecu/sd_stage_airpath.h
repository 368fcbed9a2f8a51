/* SPDX-License-Identifier: MIT */
/// sd_stage_airpath.h - diagnosis of the air path's actuators in the ecu, in its 10 ms task: inputs judged one by one, then the bank.
///
/// A needed reading older than airpath.late, or a pressure or air flow that repeats itself to the last bit, rests the decisions until a
/// new one comes. Once a sensor has repeated itself for airpath.stuck, or has been silent for its age limit (a reading out of range is as
/// none), decisions are invalid, sums begin anew, and nothing is learned.
#ifndef SD_STAGE_AIRPATH_H
#define SD_STAGE_AIRPATH_H
#include "sd_airpath_bank.h"
#include "sd_calibration.h"
#include "sd_inputs.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_NOISY 3 ///< Sensors that never read the same twice: air flow, intake and exhaust pressure.
#define SD_AIRPATH_ACTUATORS 2

/// What a sensor that should be noisy read last.
typedef struct sd_airpath_watch {
    float    value;
    uint32_t tick;
    uint32_t same_steps; ///< For how many steps it has not changed, saturating.
} sd_airpath_watch_t;

/// Owned by the stage.
typedef struct sd_stage_airpath {
    sd_airpath_bank_t   bank;
    sd_airpath_config_t config;
    float    late_s, tracking;                      ///< Parameters.
    uint32_t stuck_steps;
    float    speed_rpm;                             ///< Behind a lag that takes the firings' ripple out; 0: unknown.
    float    deviation[SD_AIRPATH_ACTUATORS];       ///< Position minus command, behind a lag of half a second.
    sd_airpath_watch_t watch[SD_AIRPATH_NOISY];
} sd_stage_airpath_t;

/// What the crank says at this time.
typedef struct sd_stage_airpath_crank {
    float   speed_rpm;
    uint8_t health;    ///< sd_health_t of it.
    uint8_t cylinders;
} sd_stage_airpath_crank_t;

typedef struct sd_stage_airpath_out {
    sd_airpath_out_t bank;
    uint8_t tracking; ///< Bits as sd_airpath_fault_t: actuators whose position does not follow the command.
} sd_stage_airpath_out_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched. A page without an air path is fine.
sd_result_t sd_stage_airpath_init(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Other parameters from the next step on; what was learned stays. SD_OK, or SD_ERR_CONFIG with nothing changed.
sd_result_t sd_stage_airpath_configure(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// 10 ms later. The page has an air path.
void sd_stage_airpath_step(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_inputs_t *inputs,
                           const sd_stage_airpath_crank_t *crank, uint32_t tick, sd_stage_airpath_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
