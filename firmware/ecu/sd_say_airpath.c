/* SPDX-License-Identifier: MIT */
/* The air path's values into signals; the same in both kinds of ecu. */
#include "sd_say_airpath.h"

#include "sd_value.h"

sd_stage_airpath_crank_t sd_say_crank_now(const sd_publish_t *say, uint8_t cylinders) {
    return (sd_stage_airpath_crank_t){ .speed_rpm = say->signals.crank_speed_rpm, .health = sd_publish_judged(say, SD_OWNER_CRANK).health,
                                       .cylinders = cylinders };
}

void sd_say_airpath(sd_publish_t *say, const sd_port_t *port, uint32_t tick, sd_stage_airpath_out_t *out, uint16_t why) {
    sd_signals_t *s = &say->signals;
    if (why != 0u) { sd_status_worst_of(&out->status, SD_DEGRADED, why); }
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
    sd_publish_row(say, port, tick, SD_RATE_AIRPATH);
}
