/* SPDX-License-Identifier: MIT */
/// sd_stage_work.h - work of a cycle (sd_work.h) in the ecu, of both kinds: what a tooth does, and what is said at the end of a window.
#ifndef SD_STAGE_WORK_H
#define SD_STAGE_WORK_H
#include "sd_calibration.h"
#include "sd_publish.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A tooth that is waited for has passed; where a window ends with it, its row of signals is said.
void sd_stage_work_edge(sd_work_meter_t *self, const sd_calibration_t *page, const sd_parameters_t *p, const sd_tooth_t *tooth,
                        sd_publish_t *say, const sd_port_t *port);

/// A placed tooth. It is no burden to most of them: two comparisons.
static inline void sd_stage_work_tooth(sd_work_meter_t *self, const sd_calibration_t *page, const sd_parameters_t *p,
                                       const sd_tooth_t *tooth, sd_publish_t *say, const sd_port_t *port) {
    if (!sd_work_passes(self, &page->work, tooth->cycle_position, tooth->advance)) { return; }
    sd_stage_work_edge(self, page, p, tooth, say, port);
}

/// The angle is new at this tooth.
static inline void sd_stage_work_jump(sd_work_meter_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth) {
    sd_work_restart(self, &page->work, tooth->cycle_position);
}

#ifdef __cplusplus
}
#endif
#endif
