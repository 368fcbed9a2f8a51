/* SPDX-License-Identifier: MIT */
#include "sd_stage_work.h"

#include "sd_value.h"

#ifdef SD_ECU_FIXED
#define READ sd_work_read_q31
#else
#define READ sd_work_read_f32
#endif

/* Whole numbers as floats, of a firing's index and of a cylinder: quicker than to make them of integers. */
static const float WHOLE[SD_CYLINDERS_MAX + 1u] = { 0.0f, 1.0f, 2.0f, 3.0f, 4.0f,
#if SD_CYLINDERS_MAX > 4
                                                    5.0f, 6.0f, 7.0f, 8.0f
#endif
};

/* Reasons beside those of the decoder. */
static void judge(const sd_calibration_t *page, const sd_tooth_t *tooth, bool known, sd_status_t *status) {
    status->health = SD_VALID;
    status->why = 0;
    if (known && (tooth->phase_known != 0u)) { return; }
    if (tooth->phase_known == 0u) { sd_status_worst_of(status, (page->work.alike != 0u) ? SD_DEGRADED : SD_INVALID, SD_WHY_NO_PHASE); }
    const bool fault = tooth->health != (uint8_t)SD_VALID;
    if (!known) { sd_status_worst_of(status, SD_INVALID, fault ? SD_WHY_FAULT : SD_WHY_CONVERGING); }
}

void sd_stage_work_edge(sd_work_meter_t *self, const sd_calibration_t *page, const sd_parameters_t *p, const sd_tooth_t *tooth,
                        sd_publish_t *say, const sd_port_t *port) {
    const uint8_t trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u;
    if (!sd_work_edge(self, &page->work, tooth->cycle_position, tooth->tick, trusted)) { return; }
    sd_work_out_t out;
    const sd_value_t edge = V(mul)(V(of)(p->torque_edge_sd_deg), V(of)(0.017453293f));
    READ(self, &page->work, V(float)(edge), &out);
    sd_status_t status;
    judge(page, tooth, out.known != 0u, &status);
    sd_signals_t *s = &say->signals;
    const uint32_t cylinder = page->firing_order[out.firing];
    const bool named = (out.change_known != 0u) && (tooth->phase_known != 0u) && (cylinder <= SD_CYLINDERS_MAX);
    s->work_cycle_j = out.work_j;
    s->work_sd_j = out.sd_j;
    s->work_change_j = out.change_j;
    s->work_firing = WHOLE[out.firing];
    s->work_cylinder = named ? WHOLE[cylinder] : 0.0f;
    sd_publish_judge(say, SD_OWNER_WORK, &status);
    sd_publish_row(say, port, tooth->tick, SD_RATE_WORK);
}
