/* SPDX-License-Identifier: MIT */
/// sd_say.h - typed values of the stages into signals: units of the signal table, cylinders by their physical number.
#ifndef SD_SAY_H
#define SD_SAY_H
#include "sd_firings.h"
#include "sd_say_edge.h"
#include "sd_stage_driveline.h"
#include "sd_say_airpath.h"
#include "sd_stage_misfire.h"
#include "sd_stage_mixture.h"
#include "sd_stage_torque.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Angle, speed, class and health of an edge. Speed and acceleration stay when the tooth has no period.
void sd_say_tooth(sd_publish_t *say, const sd_calibration_t *page, const sd_tooth_t *tooth, const sd_crank_motion_t *motion);
void sd_say_torque(sd_publish_t *say, const sd_torque_out_t *torque);
void sd_say_cylinders(sd_publish_t *say, const sd_calibration_t *page, const sd_cylinders_out_t *cylinders);
void sd_say_firing(sd_publish_t *say, const sd_calibration_t *page, const sd_firings_out_t *firings);
void sd_say_pattern(sd_publish_t *say, const sd_firings_t *firings);
void sd_say_verdict(sd_publish_t *say, const sd_stage_misfire_out_t *out);
void sd_say_misfires(sd_publish_t *say, const sd_calibration_t *page, const sd_misfire_t *monitor);
void sd_say_mixture(sd_publish_t *say, const sd_calibration_t *page, const sd_mixture_out_t *out, const sd_stage_mixture_t *mixture);
void sd_say_driveline(sd_publish_t *say, const sd_stage_driveline_t *driveline);
void sd_say_trims(sd_publish_t *say, const sd_calibration_t *page, const sd_stage_trims_t *trims);

#ifdef __cplusplus
}
#endif
#endif
