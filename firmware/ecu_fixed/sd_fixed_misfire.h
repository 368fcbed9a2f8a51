/* SPDX-License-Identifier: MIT */
/// sd_fixed_misfire.h - misfires in an ecu of fixed point: document 000's observers in q31 (sd_switched_wheel.h), by misfire.method 1 to
/// 3. The monitor (0) stands on the filters on tooth times and is not built; with it nothing is judged.
#ifndef SD_FIXED_MISFIRE_H
#define SD_FIXED_MISFIRE_H
#include "sd_calibration.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Owned by the stage.
typedef struct sd_fixed_misfire {
    sd_wheel_q31_t wheel;
    sd_status_t status;       ///< Of the last firing.
    float    converted_mg;    ///< The fuel that `work` was made from, mg a stroke.
    sd_q31_t work;            ///< per unit of the wheel's work base, negative: not known.
    float    work_per_mg;     ///< That a milligram gives, per unit.
    uint32_t misfires;        ///< Since init.
    uint16_t doubt;           ///< Positions until no firing under way holds a tooth that was not trusted.
    uint8_t  runs;            ///< 0: the method is not built.
} sd_fixed_misfire_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched: no tables in the page, or a number out of its range. Also for other parameters: an
/// observer begins anew.
sd_result_t sd_fixed_misfire_init(sd_fixed_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// The angle was lost or moved: the next firings are not judged.
void sd_fixed_misfire_restart(sd_fixed_misfire_t *self);
/// An edge that stands for no tooth was seen: firings under way are in doubt.
void sd_fixed_misfire_spurious(sd_fixed_misfire_t *self, const sd_calibration_t *page);
/// A placed tooth and the fuel commanded now, mg, below 0: not known. Returns the firing, + 1, that is to be read at it; 0: none.
uint32_t sd_fixed_misfire_tooth(sd_fixed_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg);
/// Judges a firing; inhibit: sd_inhibit_t bits that the caller knows of.
void sd_fixed_misfire_judge(sd_fixed_misfire_t *self, const sd_calibration_t *page, uint32_t firing, uint32_t inhibit,
                            sd_wheel_verdict_q31_t *v);

#ifdef __cplusplus
}
#endif
#endif
