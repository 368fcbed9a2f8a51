/* SPDX-License-Identifier: MIT */
#include "sd_fixed_trims.h"

#include <string.h>

void sd_fixed_trims_restart(sd_fixed_trims_t *self) { memset(self, 0, sizeof *self); }

static sd_q31_t limited(sd_q31_t x, sd_q31_t limit) { return (x > limit) ? limit : (x < sd_neg_q31(limit)) ? sd_neg_q31(limit) : x; }

static bool usable(const sd_parameters_t *p, uint32_t cylinders, const sd_afr_estimate_t *estimate, uint8_t health) {
    bool ok = health == (uint8_t)SD_VALID;
    for (uint32_t i = 0; i < cylinders; ++i) {
        ok = ok && sd_bits_between(estimate->deviation[i], -1.0f, 1.0f) && sd_bits_within(estimate->sd[i], 0.0f, p->balance_sd_max);
    }
    return ok;
}

static void learn(sd_fixed_trims_t *self, const sd_parameters_t *p, uint32_t cylinders, const sd_afr_estimate_t *estimate) {
    const sd_gain_q31_t gain = sd_gain_of_q31(p->balance_integral_gain), proportional = sd_gain_of_q31(p->balance_proportional_gain);
    const sd_gain_q31_t each = sd_real_gain_q31(sd_scaled_div(sd_scaled_int(1), sd_scaled_int((int32_t)cylinders)));
    const sd_q31_t rate = sd_from_float_q31(p->balance_trim_rate), limit = sd_from_float_q31(p->balance_trim_limit);
    sd_q31_t mean = 0;
    for (uint32_t i = 0; i < cylinders; ++i) {
        const sd_q31_t deviation = sd_from_float_q31(estimate->deviation[i]);
        const sd_q31_t change = (self->has_last != 0u) ? sd_gain_q31(proportional, sd_sub_q31(deviation, self->last[i])) : 0;
        self->trim[i] = sd_sub_q31(self->trim[i], limited(sd_add_q31(sd_gain_q31(gain, deviation), change), rate));
        self->last[i] = deviation;
        mean = sd_add_q31(mean, sd_gain_q31(each, self->trim[i]));
    }
    self->has_last = 1;
    self->at_limit = 0;
    for (uint32_t i = 0; i < cylinders; ++i) {
        const sd_q31_t wanted = sd_sub_q31(self->trim[i], mean);
        self->trim[i] = limited(wanted, limit);
        if (self->trim[i] != wanted) { self->at_limit = 1; }
    }
}

void sd_fixed_trims_cycle(sd_fixed_trims_t *self, const sd_parameters_t *p, uint32_t cylinders, sd_trims_wish_t wish,
                          const sd_afr_estimate_t *estimate, uint8_t health, bool transient) {
    if (wish == SD_TRIMS_OFF) {
        sd_fixed_trims_restart(self);
        return;
    }
    const uint8_t known = (wish == SD_TRIMS_FREEZE) ? (uint8_t)SD_INVALID : health;
    self->not_built = sd_bits_above_to(p->balance_source, 1.5f, 2.0f) ? 1u : 0u; /* from torque */
    if (transient || (self->not_built != 0u) || !usable(p, cylinders, estimate, known)) {
        const uint32_t hold = sd_scaled_floor(sd_scaled_of(p->balance_hold_cycles));
        self->hold = (uint16_t)((hold > 0u) ? hold : 1u);
        self->has_last = 0;
    } else if (self->hold > 0u) {
        self->hold--;
    } else {
        learn(self, p, cylinders, estimate);
    }
}

sd_status_t sd_fixed_trims_status(const sd_fixed_trims_t *self) {
    sd_status_t status = { .health = SD_VALID };
    if (self->not_built != 0u) {
        status.health = SD_INVALID;
        status.why = SD_WHY_NOT_BUILT;
    } else if ((self->hold > 0u) || (self->at_limit != 0u)) {
        status.health = SD_DEGRADED;
        status.why = (self->hold > 0u) ? SD_WHY_CONVERGING : SD_WHY_REJECTED;
    }
    return status;
}
