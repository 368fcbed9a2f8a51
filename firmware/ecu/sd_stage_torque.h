/* SPDX-License-Identifier: MIT */
/// sd_stage_torque.h - the Fourier observer in the ecu, in the number type that torque.fixed_point chooses, and the torque of each
/// cylinder that its harmonics give once a cycle.
#ifndef SD_STAGE_TORQUE_H
#define SD_STAGE_TORQUE_H
#include "sd_calibration.h"
#include "sd_course.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The observer, in one number type or the other.
typedef union sd_torque_observer {
    sd_fourier_f32_t f32;
    sd_fourier_q31_t q31;
} sd_torque_observer_t;

/// Owned by the stage.
typedef struct sd_stage_torque {
    sd_torque_observer_t observer; ///< Which type: fixed_point.
    sd_torque_observer_t ended;    ///< As it was at the end of the last cycle, from which cylinders are read.
    uint8_t fixed_point;           ///< 1: q31 runs.
    uint8_t ended_fixed_point;     ///< 1: q31 ran in the cycle that ended.
} sd_stage_torque_t;

/// What the stage says at a tooth.
typedef struct sd_torque_out {
    float       mass_nm; ///< Combustion torque less load and friction, N m; 0 while not running.
    sd_status_t status;  ///< innovation in J.
} sd_torque_out_t;

/// Torque of each cylinder over a cycle, by firing order.
typedef struct sd_cylinders_out {
    float   torque_nm[SD_CYLINDERS_MAX]; ///< Mean combustion torque over the 180 deg after TDC.
    float   sd_nm[SD_CYLINDERS_MAX];     ///< Its standard deviation from errors of the tooth times.
    uint8_t known; ///< 0: the page's map is for other gains, or there is none; nothing else is set then.
} sd_cylinders_out_t;

/// Begins anew with these parameters. SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_stage_torque_init(sd_stage_torque_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// The angle moved.
void sd_stage_torque_jump(sd_stage_torque_t *self, sd_course_jump_t jump);
/// A placed tooth.
void sd_stage_torque_tooth(sd_stage_torque_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, sd_torque_out_t *out);
/// The cycle has ended: the observer is put aside for sd_stage_torque_cylinders.
void sd_stage_torque_end_cycle(sd_stage_torque_t *self);
/// Reads the cylinders of the cycle that ended at its mean speed, rad/s; intake pressure in bar.
void sd_stage_torque_cylinders(const sd_stage_torque_t *self, const sd_calibration_t *page, const sd_parameters_t *p, float speed_radps,
                               float intake_bar, sd_cylinders_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
