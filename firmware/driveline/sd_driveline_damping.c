/* SPDX-License-Identifier: MIT */
#include "sd_driveline_damping.h"

#include "sd_math.h"

sd_result_t sd_driveline_damping_init(sd_driveline_damping_t *self, const sd_driveline_damping_config_t *config) {
    const bool ok = sd_within(config->gain_nms, 0.0f, 1e4f) && sd_within(config->limit_nm, 0.0f, 2000.0f) &&
                    sd_within(config->rate_nmps, 0.0f, 1e6f) && sd_within(config->drop_nmps, 0.0f, 1e6f);
    if (!ok) { return SD_ERR_CONFIG; }
    self->request_nm = 0.0f;
    return SD_OK;
}

float sd_driveline_damping_step(sd_driveline_damping_t *self, const sd_driveline_damping_config_t *config, float winding_radps,
                                uint8_t health, float step_s) {
    if (config->enabled == 0u) {
        self->request_nm = 0.0f;
        return 0.0f;
    }
    const bool trusted = (health == (uint8_t)SD_VALID) && sd_within(winding_radps, -1e6f, 1e6f);
    const float wanted = trusted ? sd_clamp(-config->gain_nms * winding_radps, -config->limit_nm, config->limit_nm) : 0.0f;
    const float most = (trusted ? config->rate_nmps : config->drop_nmps) * (sd_within(step_s, 0.0f, 1.0f) ? step_s : 0.0f);
    self->request_nm += sd_clamp(wanted - self->request_nm, -most, most);
    return self->request_nm;
}
