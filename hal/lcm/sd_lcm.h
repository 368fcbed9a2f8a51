/* SPDX-License-Identifier: MIT */
/// sd_lcm.h - the LCM port: messages as sixdeg.lcm says, one each way between two clock events.
///
/// Channels: SIXDEG_INPUTS, SIXDEG_OUTPUTS, SIXDEG_TRUTH, SIXDEG_PARAMETER_REQUEST, SIXDEG_PARAMETER, SIXDEG_CLAIM. An
/// ecu does not subscribe to truth. Nothing here blocks but sd_lcm_wait.
#ifndef SD_LCM_H
#define SD_LCM_H
#include <lcm/lcm.h>

#include "sd_lcm_codec.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The port on one provider. Caller-owned.
typedef struct sd_lcm {
    lcm_t *lcm; ///< Of the library; NULL when closed.
    sd_lcm_codec_t codec;
} sd_lcm_t;

/// `url` "" is LCM's own default. 0, or -1 when LCM cannot use it.
int  sd_lcm_open(sd_lcm_t *self, const char *url, sd_role_t role, uint16_t session);
/// Leaves the bus and frees what the library holds.
void sd_lcm_close(sd_lcm_t *self);
/// Its end for events; lives as long as *self is open.
sd_port_t sd_lcm_port(sd_lcm_t *self);
/// Waits until a message comes, at most so long, and takes it. 1: one came.
int  sd_lcm_wait(sd_lcm_t *self, int milliseconds);
/// Sends a claim at once.
void sd_lcm_claim(sd_lcm_t *self, sd_claim_t claim);
/// Adds to the truth that goes with the next clock event; SD_TRUTH_END goes at once.
void sd_lcm_truth(sd_lcm_t *self, const sd_truth_t *truth);

#ifdef __cplusplus
}
#endif

#endif
