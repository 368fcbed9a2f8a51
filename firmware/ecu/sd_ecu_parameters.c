/* SPDX-License-Identifier: MIT */
/* The working parameters while the engine runs. A value goes to the stage that owns it; what is learned stays where that is
 * possible, and a block that must begin anew says converging. */
#include "sd_ecu_parts.h"

#define INDEX_OF SD_PARAMETER_INDEX

sd_firings_config_t sd_ecu_firings_config(const sd_calibration_t *page, const sd_parameters_t *p) {
    return (sd_firings_config_t){ .torque_base_nm = p->torque_torque_base_nm,
                                  .reject_deg = p->firing_reject_lateness_deg,
                                  .settle_cycles = p->firing_settle_cycles,
                                  .pattern_deg = p->firing_pattern_sd_deg,
                                  .teeth = (uint8_t)(page->positions - page->missing_count),
                                  .enabled = (p->firing_enabled > 0.5f) ? 1u : 0u };
}

static sd_result_t configure_firings(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_firings_config_t config = sd_ecu_firings_config(page, &self->working);
    return sd_firings_configure(&self->firings, &config, &page->kalman);
}

static sd_result_t apply_torque(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index) {
    if (index == INDEX_OF(torque_edge_sd_deg)) { return SD_OK; } /* read at the end of each cycle */
    const sd_result_t result = sd_stage_torque_init(&self->torque, page, &self->working);
    return (result == SD_OK) ? configure_firings(self, page) : result;
}

static sd_result_t apply_firing(sd_ecu_t *self, const sd_calibration_t *page) {
    const bool rested = self->firings.enabled == 0u, wanted = self->working.firing_enabled > 0.5f;
    if ((page->kalman.positions == 0u) && wanted) { return SD_ERR_CONFIG; }
    if (configure_firings(self, page) != SD_OK) { return SD_ERR_CONFIG; }
    if (rested && wanted) { sd_misfire_start(&self->misfire.monitor); } /* document 000's observer goes on */
    return SD_OK;
}

static sd_result_t apply_balance(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index) {
    if (index == INDEX_OF(balance_source)) { sd_stage_trims_restart(&self->trims); }
    return sd_stage_trims_configure(&self->trims, page, &self->working);
}

static sd_result_t apply_afr(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index) {
    const bool read_each_cycle = (index == INDEX_OF(afr_delay_learning)) || (index == INDEX_OF(afr_delay_probe)) ||
                                 (index == INDEX_OF(afr_delay_error_sd_s)) || (index == INDEX_OF(afr_lag_error_sd));
    return read_each_cycle ? SD_OK : sd_stage_mixture_configure(&self->mixture, page, &self->working);
}

sd_result_t sd_ecu_apply(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index) {
    switch (sd_parameter_infos[index].owner) {
    case SD_OWNER_CRANK:   return sd_crank_set_stall(&self->crank, sd_calibration_crank(page, &self->working).stall_ticks);
    case SD_OWNER_TORQUE:  return apply_torque(self, page, index);
    case SD_OWNER_FIRING:  return apply_firing(self, page);
    case SD_OWNER_MISFIRE: return sd_stage_misfire_configure(&self->misfire, page, &self->working);
    case SD_OWNER_AFR:     return apply_afr(self, page, index);
    case SD_OWNER_BALANCE: return apply_balance(self, page, index);
    case SD_OWNER_DRIVELINE: return sd_stage_driveline_configure(&self->driveline, &self->working);
    case SD_OWNER_AIRPATH: return sd_stage_airpath_configure(&self->airpath, page, &self->working);
    default:               return SD_ERR_CONFIG; /* no other stage has any */
    }
}
