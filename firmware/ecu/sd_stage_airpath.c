/* SPDX-License-Identifier: MIT */
#include "sd_stage_airpath.h"

static bool wants_fixed(const sd_parameters_t *p) { return p->airpath_arithmetic > 0.5f; }

/* Numbers that are not there. */
static bool lacks(const sd_calibration_t *page, bool fixed) { return fixed && (page->airpath.present != page->airpath_q31.present); }

sd_result_t sd_stage_airpath_init(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const bool fixed = wants_fixed(p);
    if (lacks(page, fixed)) { return SD_ERR_CONFIG; }
    const sd_result_t result = fixed ? sd_stage_airpath_init_q31(&self->in.q31, page, p)
        : sd_stage_airpath_init_f32(&self->in.f32, page, p);
    if (result == SD_OK) { self->fixed_point = fixed ? 1u : 0u; }
    return result;
}

sd_result_t sd_stage_airpath_configure(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const bool fixed = wants_fixed(p);
    if (fixed != (self->fixed_point != 0u)) { return sd_stage_airpath_init(self, page, p); }
    return fixed ? sd_stage_airpath_configure_q31(&self->in.q31, page, p) : sd_stage_airpath_configure_f32(&self->in.f32, page, p);
}

void sd_stage_airpath_step(sd_stage_airpath_t *self, const sd_calibration_t *page, const sd_inputs_t *inputs,
                           const sd_stage_airpath_crank_t *crank, uint32_t tick, sd_stage_airpath_out_t *out) {
    if (self->fixed_point != 0u) {
        sd_stage_airpath_step_q31(&self->in.q31, page, inputs, crank, tick, out);
    } else {
        sd_stage_airpath_step_f32(&self->in.f32, page, inputs, crank, tick, out);
    }
}
