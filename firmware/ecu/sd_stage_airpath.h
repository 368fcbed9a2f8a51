/* SPDX-License-Identifier: MIT */
/// sd_stage_airpath.h - diagnosis of the air path's actuators in the ecu, in its 10 ms task: inputs judged one by one, then the bank.
///
/// A needed reading older than airpath.late_after, or a pressure or air flow that repeats itself to the last bit, rests the decisions until
/// a new one comes. Once a sensor has repeated itself for airpath.stuck_after, or has been silent for its age limit (a reading out of range
/// is as none), decisions are invalid, sums begin anew, and nothing is learned.
///
/// Two variants from one body: the usual ecu runs either, as airpath.arithmetic has it, an ecu of fixed point _q31, without floating-point
/// arithmetic. Floats of inputs, parameters and of what is said are only carried there.
#ifndef SD_STAGE_AIRPATH_H
#define SD_STAGE_AIRPATH_H
#include "sd_calibration.h"
#include "sd_inputs.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_NOISY 3 ///< Sensors that never read the same twice: air flow, intake and exhaust pressure.
#define SD_AIRPATH_ACTUATORS 2 ///< EGR valve and turbine vanes.
#define SD_AIRPATH_SAID 4 ///< Decision functions that are said: those of the actuators.

/// What a sensor that should be noisy read last.
typedef struct sd_airpath_watch {
    float    value;      ///< In the unit of its signal.
    uint32_t tick;       ///< Capture ticks of that reading.
    uint32_t same_steps; ///< For how many steps it has not changed, saturating.
} sd_airpath_watch_t;

/// What the crank says at this time.
typedef struct sd_stage_airpath_crank {
    float   speed_rpm; ///< Of the crank.
    uint8_t health;    ///< sd_health_t of it.
    uint8_t cylinders; ///< 1 to 8.
} sd_stage_airpath_crank_t;

/// What is said of a step, in the units of the signals.
typedef struct sd_stage_airpath_out {
    float residual_kpa[SD_AIRPATH_RESIDUALS], offset_faults[SD_AIRPATH_RESIDUALS]; ///< Residuals; offsets per fault of interest, as in
                                                                                   ///< sd_airpath_out_f32_t.
    float decision[SD_AIRPATH_SAID]; ///< Sums of sd_cusum.h, log of a likelihood ratio, >= 0.
    float since_s;    ///< Time since the fault's most likely beginning; 0 without one.
    uint8_t fault;    ///< sd_airpath_fault_t.
    uint8_t phase;    ///< sd_airpath_phase_t.
    uint8_t tracking; ///< Bits as sd_airpath_fault_t: actuators whose position does not follow the command.
    sd_status_t status;
} sd_stage_airpath_out_t;

/// State and functions of the stage in one number type: N is f32 or q31, T its type.
#define SD_STAGE_AIRPATH_DECLARE(N, T)                                                                                 \
    /* Owned by the stage. */                                                                                          \
    typedef struct sd_stage_airpath_##N {                                                                              \
        sd_airpath_bank_##N##_t   bank;                                                                                \
        sd_airpath_config_##N##_t config;                                                                              \
        T        tracking;                        /* Parameter. */                                                     \
        T        speed_rpm;                       /* Behind a lag that takes the firings' ripple out; 0: unknown. */   \
        T        deviation[SD_AIRPATH_ACTUATORS]; /* Position minus command, behind a lag of half a second. */         \
        int32_t  late_ticks;                                                                                           \
        uint32_t stuck_steps;                                                                                          \
        sd_airpath_watch_t watch[SD_AIRPATH_NOISY];                                                                    \
    } sd_stage_airpath_##N##_t;                                                                                        \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. A page without an air path is fine. */                        \
    sd_result_t sd_stage_airpath_init_##N(sd_stage_airpath_##N##_t *self, const sd_calibration_t *page, const sd_parameters_t *p); \
    /* Other parameters from the next step on; what was learned stays. SD_OK, or SD_ERR_CONFIG with nothing changed. */ \
    sd_result_t sd_stage_airpath_configure_##N(sd_stage_airpath_##N##_t *self, const sd_calibration_t *page, const sd_parameters_t *p); \
    /* 10 ms later. The page has an air path in these numbers. */                                                      \
    void sd_stage_airpath_step_##N(sd_stage_airpath_##N##_t *self, const sd_calibration_t *page, const sd_inputs_t *inputs, \
                                   const sd_stage_airpath_crank_t *crank, uint32_t tick, sd_stage_airpath_out_t *out);

SD_STAGE_AIRPATH_DECLARE(f32, float)
SD_STAGE_AIRPATH_DECLARE(q31, sd_q31_t)

/// Of the usual ecu: either of them, and as they do. Another arithmetic begins anew; q31 without its tables in the page is refused.
typedef struct sd_stage_airpath {
    union { sd_stage_airpath_f32_t f32; sd_stage_airpath_q31_t q31; } in;
    uint8_t fixed_point; ///< 1: q31.
} sd_stage_airpath_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched: the page has no tables for the arithmetic that is asked for.
sd_result_t sd_stage_airpath_init(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
sd_result_t sd_stage_airpath_configure(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// A period later: takes the readings as they stand and fills *out.
void sd_stage_airpath_step(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_inputs_t *inputs,
                           const sd_stage_airpath_crank_t *crank, uint32_t tick, sd_stage_airpath_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
