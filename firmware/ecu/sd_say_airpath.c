/* SPDX-License-Identifier: MIT */
/* The air path's values into signals; the same in both kinds of ecu. */
#include "sd_say_airpath.h"

#include "sd_value.h"

void sd_say_airpath(sd_publish_t *say, const sd_stage_airpath_out_t *out) {
    sd_signals_t *s = &say->signals;
    for (uint32_t i = 0; i < (uint32_t)SD_AIRPATH_RESIDUALS; ++i) {
        s->airpath_residual_kpa[i] = out->residual_kpa[i];
        s->airpath_offset[i] = out->offset_faults[i];
    }
    for (uint32_t l = 0; l < (uint32_t)SD_AIRPATH_SAID; ++l) { s->airpath_decision[l] = out->decision[l]; }
    s->airpath_fault = V(float)(V(int)(out->fault));
    s->airpath_since_s = out->since_s;
    s->airpath_phase = V(float)(V(int)(out->phase));
    s->airpath_tracking = V(float)(V(int)(out->tracking));
    sd_publish_judge(say, SD_OWNER_AIRPATH, &out->status);
}
