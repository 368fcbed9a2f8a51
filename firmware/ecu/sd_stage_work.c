/* SPDX-License-Identifier: MIT */
#include "sd_stage_work.h"

#include "sd_value.h"

#ifdef SD_ECU_FIXED
#define READ sd_work_read_q31
#else
#define READ sd_work_read_f32
#endif

static sd_status_t judge(const sd_calibration_t *page, const sd_tooth_t *tooth, const sd_work_out_t *out) {
    sd_status_t status = { .health = SD_VALID };
    if (tooth->phase_known == 0u) { sd_status_worst_of(&status, (page->work.alike != 0u) ? SD_DEGRADED : SD_INVALID, SD_WHY_NO_PHASE); }
    if (out->known != 0u) { return status; }
    const bool fault = tooth->health != (uint8_t)SD_VALID;
    sd_status_worst_of(&status, SD_INVALID, fault ? SD_WHY_FAULT : SD_WHY_CONVERGING);
    return status;
}

void sd_stage_work_edge(sd_work_meter_t *self, const sd_calibration_t *page, const sd_parameters_t *p, const sd_tooth_t *tooth,
                        sd_publish_t *say, const sd_port_t *port) {
    const uint8_t trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u;
    if (!sd_work_edge(self, &page->work, tooth->cycle_position, tooth->tick, trusted)) { return; }
    sd_work_out_t out;
    const sd_value_t edge = V(mul)(V(of)(p->torque_tooth_sd_deg), V(of)(0.017453293f));
    READ(self, &page->work, V(float)(edge), &out);
    const sd_status_t status = judge(page, tooth, &out);
    sd_signals_t *s = &say->signals;
    const bool named = (out.change_known != 0u) && (tooth->phase_known != 0u);
    s->work_cycle_j = out.work_j;
    s->work_sd_j = out.sd_j;
    s->work_change_j = out.change_j;
    s->work_firing = V(float)(V(int)(out.firing));
    s->work_cylinder = named ? V(float)(V(int)(page->firing_order[out.firing])) : 0.0f;
    sd_publish_judge(say, SD_OWNER_WORK, &status);
    sd_publish_row(say, port, tooth->tick, SD_RATE_WORK);
}
