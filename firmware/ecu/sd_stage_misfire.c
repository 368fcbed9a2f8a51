/* SPDX-License-Identifier: MIT */
#include "sd_stage_misfire.h"

sd_result_t sd_stage_misfire_init(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_misfire_config_t config = sd_calibration_misfire(page, p);
    const sd_result_t result = sd_misfire_init(&self->monitor, &config);
    if (result != SD_OK) { return result; }
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) { self->fuel_mg[i] = SD_FUEL_UNKNOWN; }
    self->fuel_level_min_percent = p->misfire_fuel_level_min_percent;
    return SD_OK;
}

sd_result_t sd_stage_misfire_configure(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_misfire_config_t config = sd_calibration_misfire(page, p);
    const sd_result_t result = sd_misfire_configure(&self->monitor, &config);
    if (result == SD_OK) { self->fuel_level_min_percent = p->misfire_fuel_level_min_percent; }
    return result;
}

void sd_stage_misfire_tooth(sd_stage_misfire_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, float fuel_mg) {
    const uint32_t cycle = 2u * page->positions, at = (uint32_t)self->position + tooth->advance;
    const bool follows = tooth->cycle_position == ((at >= cycle) ? at - cycle : at);
    self->position = tooth->cycle_position;
    if (follows && (tooth->advance < self->until_tdc)) {
        self->until_tdc = (uint16_t)(self->until_tdc - tooth->advance);
        return;
    }
    uint32_t until = cycle;
    for (uint32_t i = 0; i < page->cylinders; ++i) {
        const uint32_t tdc = page->firing_position[i];
        const uint32_t since = (tooth->cycle_position >= tdc) ? tooth->cycle_position - tdc : tooth->cycle_position + cycle - tdc;
        if (since < tooth->advance) { self->fuel_mg[i] = fuel_mg; }
        if (cycle - since < until) { until = cycle - since; }
    }
    self->until_tdc = (uint16_t)until;
}

/* What forbids to judge the firing, beyond what the monitor sees itself. */
static uint8_t inhibits(const sd_stage_misfire_t *self, const sd_stage_misfire_in_t *in) {
    const uint32_t spoilt = (uint32_t)SD_WHY_FAULT | (uint32_t)SD_WHY_REJECTED;
    uint32_t why = 0;
    if ((in->estimate.why & (uint32_t)SD_WHY_CONVERGING) != 0u) { why |= SD_INHIBIT_ESTIMATE; }
    if ((self->fuel_mg[in->firing->index] < 0.0f) || ((in->estimate.why & spoilt) != 0u)) { why |= SD_INHIBIT_OUTSIDE; }
    if (in->shifting) { why |= SD_INHIBIT_SHIFT; }
    if (in->level_known && (in->fuel_level_percent < self->fuel_level_min_percent)) { why |= SD_INHIBIT_LEVEL; }
    return (uint8_t)why;
}

sd_misfire_verdict_t sd_stage_misfire_firing(sd_stage_misfire_t *self, const sd_stage_misfire_in_t *in) {
    const sd_misfire_firing_t seen = { .index = in->firing->index,
                                       .health = in->estimate.health,
                                       .inhibit = inhibits(self, in),
                                       .torque_nm = in->firing->torque_nm,
                                       .torque_sd_nm = in->firing->sd_nm,
                                       .fuel_mg = self->fuel_mg[in->firing->index],
                                       .speed_radps = in->speed_radps,
                                       .energy_j = in->energy_j };
    return sd_misfire_judge(&self->monitor, &seen);
}
