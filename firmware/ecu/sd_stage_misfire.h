/* SPDX-License-Identifier: MIT */
/// sd_stage_misfire.h - misfires in the ecu: which fuel each firing was given, when it is not judged, and who judges it.
///
/// The monitor (sd_misfire.h) judges each firing of the filter on tooth times, always. With misfire.method one of document 000's
/// observers (sd_switched_wheel.h) runs beside it, in single precision or fixed point, and then its verdict is the one that counts:
/// for rates, for the lamp, and for the trims.
#ifndef SD_STAGE_MISFIRE_H
#define SD_STAGE_MISFIRE_H
#include <stdbool.h>

#include "sd_calibration.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_FUEL_UNKNOWN (-1.0f) ///< In place of a commanded fuel, mg.

/// As misfire.method has it; from 1 on sd_wheel_kind_t + 1.
typedef enum sd_method {
    SD_METHOD_MONITOR, ///< From the torque of single firings (sd_misfire.h).
    SD_METHOD_FOLSMO,  ///< Document 000's observers (sd_switched_wheel.h), and so below.
    SD_METHOD_FOSMO,   ///< First order sliding mode.
    SD_METHOD_ROO,     ///< Reduced order.
} sd_method_t;

/// Owned by the stage.
typedef struct sd_stage_misfire {
    sd_misfire_t monitor;
    union { sd_wheel_f32_t f32; sd_wheel_q31_t q31; } wheel; ///< With another method than the monitor.
    sd_status_t status;              ///< Of the method's last firing.
    float    fuel_mg[SD_CYLINDERS_MAX]; ///< Commanded at the last TDC of each firing; SD_FUEL_UNKNOWN where no command was fresh.
    float    fuel_level_min_percent; ///< Fuel level below which firings are not judged.
    float    work_per_mg;            ///< Work of 1 mg of fuel, per unit of the wheel's work base.
    float    converted_mg;           ///< The fuel that `work` was made from.
    sd_q31_t work;                   ///< Work of that fuel, per unit of the wheel's work base.
    uint16_t doubt;                  ///< Positions until no firing under way holds a tooth that was not trusted.
    uint8_t  method;                 ///< sd_method_t.
    uint8_t  fixed_point;            ///< 1: q31.
    uint16_t position;               ///< Cycle position of the last placed tooth.
    uint16_t until_tdc;              ///< Positions from `position` to the next TDC of a firing; 0: not known.
} sd_stage_misfire_t;

/// A firing that is to be judged, and what is known beside it.
typedef struct sd_stage_misfire_in {
    uint32_t firing;            ///< In firing order, from 0.
    const sd_firing_t *read;    ///< Its torque; NULL where no filter runs, and the monitor says nothing.
    sd_status_t estimate;       ///< Of that torque.
    float   energy_j;           ///< Kinetic energy of the crank.
    float   speed_radps;        ///< Of the crank at the firing.
    bool    phase_known;        ///< The cycle's revolution is known.
    bool    geared;             ///< It is known that a gear is in and the clutch closed.
    bool    shifting;           ///< The controller says that a gear is being shifted.
    bool    level_known;        ///< A fuel level was told.
    float   fuel_level_percent; ///< Where known.
} sd_stage_misfire_in_t;

/// What is said of it.
typedef struct sd_stage_misfire_out {
    sd_misfire_verdict_t verdict;       ///< Of the method.
    uint8_t monitor;                    ///< sd_verdict_t of the monitor.
    float   accel_radps2, residual_radps2; ///< Of document 000's observer; 0 where none runs or nothing was read.
} sd_stage_misfire_out_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched; also for a method whose tables the page does not hold.
sd_result_t sd_stage_misfire_init(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Other parameters from the next firing on; as sd_misfire_configure. Another method or arithmetic starts its observer anew.
sd_result_t sd_stage_misfire_configure(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p);

/// One of document 000's observers runs.
static inline bool sd_stage_misfire_observes(const sd_stage_misfire_t *self) { return self->method != (uint8_t)SD_METHOD_MONITOR; }

/// The angle was lost or moved: the next firings are not judged.
void sd_stage_misfire_restart(sd_stage_misfire_t *self);
/// An edge that stands for no tooth was seen: firings under way are in doubt.
void sd_stage_misfire_spurious(sd_stage_misfire_t *self, const sd_calibration_t *page);

/// A placed tooth, and the fuel commanded now, mg, or SD_FUEL_UNKNOWN. A firing is judged by the command at its TDC: it is read
/// 300 deg later, when the command may have changed. Returns the firing, + 1, that an observer of document 000 would have read at this
/// tooth; 0: none.
uint32_t sd_stage_misfire_tooth(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg);

/// Judges a firing.
void sd_stage_misfire_firing(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_stage_misfire_in_t *in,
                             sd_stage_misfire_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
