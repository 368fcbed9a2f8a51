/* SPDX-License-Identifier: MIT */
/* The working page while the engine runs. A value goes to the block that owns it; what is learned stays where that is
 * possible, and a block that must begin anew says converging. */
#include <string.h>

#include "sd_ecu_afr.h"
#include "sd_ecu_parts.h"

#define INDEX_OF(field) ((uint32_t)(offsetof(sd_parameters_t, field) / sizeof(float)))

static float *working(sd_ecu_t *self) { return (float *)&self->calibration.parameters; }
static const float *reference(const sd_ecu_t *self) { return (const float *)&self->reference; }

static sd_result_t configure_firings(sd_ecu_t *self) {
    const sd_firings_config_t config = sd_ecu_firings_config(&self->calibration);
    return sd_firings_configure(&self->firings, &config, &self->calibration.kalman);
}

static sd_result_t apply_torque(sd_ecu_t *self, uint32_t index) {
    const sd_fourier_config_t config = sd_calibration_torque(&self->calibration);
    if (index == INDEX_OF(torque_tooth_sd_deg)) { return SD_OK; } /* read at the end of each cycle */
    const sd_result_t result = (self->calibration.parameters.torque_fixed_point > 0.5f)
                                   ? sd_fourier_init_q31(&self->torque.q31, &config, &self->calibration.fourier)
                                   : sd_fourier_init_f32(&self->torque.f32, &config, &self->calibration.fourier);
    return (result == SD_OK) ? configure_firings(self) : result;
}

static sd_result_t apply_firing(sd_ecu_t *self, uint32_t index) {
    if (index == INDEX_OF(firing_enabled)) {
        if ((self->calibration.kalman.positions == 0u) && (self->calibration.parameters.firing_enabled > 0.5f)) { return SD_ERR_CONFIG; }
    }
    const bool rested = self->firings.enabled == 0u;
    if (configure_firings(self) != SD_OK) { return SD_ERR_CONFIG; }
    if (rested) { sd_ecu_firing_restart(self); }
    return SD_OK;
}

static sd_result_t apply_balance(sd_ecu_t *self, uint32_t index) {
    const sd_balance_config_t config = sd_ecu_balance_config(&self->calibration);
    if (config.cylinders < 2u) { return SD_OK; }
    if (index == INDEX_OF(balance_source)) { sd_balance_restart(&self->balance); }
    return sd_balance_configure(&self->balance, &config);
}

static sd_result_t apply_afr(sd_ecu_t *self, uint32_t index) {
    if ((index == INDEX_OF(afr_identify)) || (index == INDEX_OF(afr_probe)) || (index == INDEX_OF(afr_late_error_s)) ||
        (index == INDEX_OF(afr_lag_error))) { return SD_OK; } /* read at the end of each cycle */
    return sd_ecu_afr_init(&self->afr, &self->calibration);
}

/* Takes the working page over into the block that owns the parameter: whole, or on an error not at all. */
static sd_result_t apply(sd_ecu_t *self, uint32_t index) {
    const sd_calibration_t *c = &self->calibration;
    const sd_misfire_config_t misfire = sd_calibration_misfire(c);
    switch (sd_parameter_infos[index].owner) {
    case SD_OWNER_CRANK:   return sd_crank_set_stall(&self->crank, sd_calibration_crank(c).stall_ticks);
    case SD_OWNER_TORQUE:  return apply_torque(self, index);
    case SD_OWNER_FIRING:  return apply_firing(self, index);
    case SD_OWNER_MISFIRE: return sd_misfire_configure(&self->misfire, &misfire);
    case SD_OWNER_AFR:     return apply_afr(self, index);
    case SD_OWNER_BALANCE: return apply_balance(self, index);
    default:               return SD_ERR_CONFIG; /* no other block has any */
    }
}

static sd_parameter_result_t set(sd_ecu_t *self, uint32_t index, float value) {
    const sd_signal_info_t *info = &sd_parameter_infos[index];
    float *const at = &working(self)[index], before = *at;
    if (!((value >= info->low) && (value <= info->high))) { return SD_PARAMETER_RANGE; } /* NaN too */
    if (value == before) { return SD_PARAMETER_OK; }
    if (info->at_start != 0u) { return SD_PARAMETER_AT_START; }
    *at = value;
    if (apply(self, index) == SD_OK) { return SD_PARAMETER_OK; }
    *at = before;
    return SD_PARAMETER_REFUSED;
}

/* All at once: one by one, a value may not go with one that is still to come. */
static sd_parameter_result_t restore_all(sd_ecu_t *self) {
    const sd_parameters_t before = self->calibration.parameters;
    self->calibration.parameters = self->reference;
    for (uint32_t i = 0; i < SD_PARAMETER_COUNT; ++i) {
        if (((const float *)&before)[i] != reference(self)[i]) { (void)apply(self, i); } /* it has run with this page */
    }
    return SD_PARAMETER_OK;
}

static sd_parameter_result_t command(sd_ecu_t *self, uint32_t index, uint32_t what, float value) {
    switch (what) {
    case SD_PARAMETER_SET:     return set(self, index, value);
    case SD_PARAMETER_RESTORE: return set(self, index, reference(self)[index]);
    default:                   return SD_PARAMETER_OK;
    }
}

void sd_ecu_parameter(sd_ecu_t *self, const sd_port_t *port, const sd_event_t *request) {
    sd_event_t answer = *request;
    sd_parameter_result_t result = SD_PARAMETER_UNKNOWN;
    const uint32_t index = request->channel;
    answer.value = 0;
    if ((index == SD_PARAMETER_ALL) && (request->flags == SD_PARAMETER_RESTORE)) {
        result = restore_all(self);
    } else if ((index < SD_PARAMETER_COUNT) && (request->flags <= SD_PARAMETER_RESTORE)) {
        float value;
        memcpy(&value, &request->value, sizeof value);
        result = command(self, index, request->flags, value);
        const float *page = (request->flags == SD_PARAMETER_READ_REFERENCE) ? reference(self) : working(self);
        memcpy(&answer.value, &page[index], sizeof answer.value);
    }
    answer.flags = (request->flags & 0xffu) | ((uint32_t)result << 8);
    (void)port->send(port->context, &answer, 1u);
}
