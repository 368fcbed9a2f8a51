/* SPDX-License-Identifier: MIT */
/// sd_say_edge.h - what both kinds of ecu say of an edge and of their inputs, in the units of the signal table.
#ifndef SD_SAY_EDGE_H
#define SD_SAY_EDGE_H
#include "sd_calibration.h"
#include "sd_inputs.h"
#include "sd_publish.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The angle is lost: what depends on it is 0.
void sd_say_lost_angle(sd_publish_t *say, uint8_t health, uint16_t why);
/// Which inputs are missing or stale, bit by bit.
void sd_say_inputs(sd_publish_t *say, const sd_inputs_t *inputs);

#ifdef __cplusplus
}
#endif
#endif
