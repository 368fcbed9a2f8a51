/* SPDX-License-Identifier: MIT */
/// sd_say_airpath.h - what the air path's stage found, into signals.
#ifndef SD_SAY_AIRPATH_H
#define SD_SAY_AIRPATH_H
#include "sd_publish.h"
#include "sd_stage_airpath.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Values and health of a step; sent with the next row of them.
void sd_say_airpath(sd_publish_t *say, const sd_stage_airpath_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
