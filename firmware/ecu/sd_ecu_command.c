/* SPDX-License-Identifier: MIT */
/* Commands for the working parameters; the same in both kinds of ecu. */
#include <string.h>

#include "sd_ecu_parts.h"
#include "sd_scaled.h"

static float *working(sd_ecu_t *self) { return (float *)&self->working; }
static const float *reference(const sd_ecu_t *self) { return (const float *)&self->reference; }

static sd_parameter_result_t set(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index, float value) {
    const sd_signal_info_t *info = &sd_parameter_infos[index];
    float *const at = &working(self)[index], before = *at;
    if (!sd_bits_within(value, info->low, info->high)) { return SD_PARAMETER_RANGE; } /* NaN too */
    if (sd_bits_order(value) == sd_bits_order(before)) { return SD_PARAMETER_OK; }
    if (info->at_start != 0u) { return SD_PARAMETER_AT_START; }
    *at = value;
    if (sd_ecu_apply(self, page, index) == SD_OK) { return SD_PARAMETER_OK; }
    *at = before;
    return SD_PARAMETER_REFUSED;
}

/* All at once: one by one, a value may not go with one that is still to come. */
static sd_parameter_result_t restore_all(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_parameters_t before = self->working;
    self->working = self->reference;
    for (uint32_t i = 0; i < SD_PARAMETER_COUNT; ++i) {
        const float was = ((const float *)&before)[i], is = reference(self)[i];
        if (sd_bits_order(was) != sd_bits_order(is)) { (void)sd_ecu_apply(self, page, i); } /* it has run with this page */
    }
    return SD_PARAMETER_OK;
}

static sd_parameter_result_t command(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index, uint32_t what, float value) {
    switch (what) {
    case SD_PARAMETER_SET:     return set(self, page, index, value);
    case SD_PARAMETER_RESTORE: return set(self, page, index, reference(self)[index]);
    default:                   return SD_PARAMETER_OK;
    }
}

void sd_ecu_parameter(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_event_t *request) {
    sd_event_t answer = *request;
    sd_parameter_result_t result = SD_PARAMETER_UNKNOWN;
    const uint32_t index = request->channel;
    answer.value = 0;
    if ((index == SD_PARAMETER_ALL) && (request->flags == SD_PARAMETER_RESTORE)) {
        result = restore_all(self, page);
    } else if ((index < SD_PARAMETER_COUNT) && (request->flags <= SD_PARAMETER_RESTORE)) {
        float value;
        memcpy(&value, &request->value, sizeof value);
        result = command(self, page, index, request->flags, value);
        const float *shown = (request->flags == SD_PARAMETER_READ_REFERENCE) ? reference(self) : working(self);
        memcpy(&answer.value, &shown[index], sizeof answer.value);
    }
    answer.flags = (request->flags & 0xffu) | ((uint32_t)result << 8);
    (void)port->send(port->context, &answer, 1u);
}
