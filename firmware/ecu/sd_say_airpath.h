/* SPDX-License-Identifier: MIT */
/// sd_say_airpath.h - what the air path's stage found, into signals.
#ifndef SD_SAY_AIRPATH_H
#define SD_SAY_AIRPATH_H
#include "sd_publish.h"
#include "sd_stage_airpath.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What was last said of the crank, for the stage's next step; cylinders: 1 to 8.
sd_stage_airpath_crank_t sd_say_crank_now(const sd_publish_t *say, uint8_t cylinders);
/// Values and health of a step, and their row goes out. why: beside what it is worth anyway, and then at least degraded; 0: nothing.
void sd_say_airpath(sd_publish_t *say, const sd_port_t *port, uint32_t tick, sd_stage_airpath_out_t *out, uint16_t why);

#ifdef __cplusplus
}
#endif
#endif
