/* SPDX-License-Identifier: MIT */
/// sd_stage_misfire.h - the misfire monitor in the ecu: which fuel each firing was given, and when it is not judged.
#ifndef SD_STAGE_MISFIRE_H
#define SD_STAGE_MISFIRE_H
#include "sd_calibration.h"
#include "sd_misfire.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_FUEL_UNKNOWN (-1.0f) ///< In place of a commanded fuel, mg.

/// Owned by the stage.
typedef struct sd_stage_misfire {
    sd_misfire_t monitor;
    float fuel_mg[SD_CYLINDERS_MAX]; ///< Commanded at the last TDC of each firing; SD_FUEL_UNKNOWN where no command was fresh.
    float fuel_level_min_percent;
    uint16_t position;               ///< Cycle position of the last placed tooth,
    uint16_t until_tdc;              ///< and positions from there to the next TDC of a firing; 0: not known.
} sd_stage_misfire_t;

/// A firing that was read, and what is known beside it.
typedef struct sd_stage_misfire_in {
    const sd_firing_t *firing;
    sd_status_t estimate;       ///< Of the firing.
    float   energy_j;           ///< Kinetic energy of the crank.
    float   speed_radps;
    bool    shifting;           ///< The controller says that a gear is being shifted.
    bool    level_known;
    float   fuel_level_percent; ///< Where known.
} sd_stage_misfire_in_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_stage_misfire_init(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Other parameters from the next firing on; as sd_misfire_configure.
sd_result_t sd_stage_misfire_configure(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p);

/// A placed tooth, and the fuel commanded now, mg, or SD_FUEL_UNKNOWN. A firing is judged by the command at its TDC: it is read
/// 300 deg later, when the command may have changed.
void sd_stage_misfire_tooth(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg);

/// Judges a firing.
sd_misfire_verdict_t sd_stage_misfire_firing(sd_stage_misfire_t *self, const sd_stage_misfire_in_t *in);

#ifdef __cplusplus
}
#endif
#endif
