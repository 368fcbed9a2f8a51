/* SPDX-License-Identifier: MIT */
/* The delay to the lambda sensor: what is learned of it goes into the filter, and when a probe may ask for it. */
#include "sd_ecu_afr.h"

enum { PROBE_AFTER = 40 }; /* cycles of learning trims: what is far off has shown by then without a probe */

#define KNOWN_RAD  0.175f /* crank: a delay known to this needs no probe */
#define MENDED_RAD 0.5f   /* crank: a delay found to be off by more makes the trims' loop another one */

sd_result_t sd_ecu_delay_init(sd_afr_delay_t *delay, const sd_calibration_t *c) {
    const sd_afr_delay_config_t config = { .cycle_positions = (uint16_t)(2u * c->positions), .cylinders = c->cylinders,
                                           .tau1_s = c->afr.tau1_s, .tau2_s = c->afr.tau2_s };
    *delay = (sd_afr_delay_t){ 0 };
    return ((c->afr.present == 0u) || (c->cylinders < 2u)) ? SD_OK : sd_afr_delay_init(delay, &config);
}

static void learn(sd_ecu_t *self, float speed_radps, bool steady) {
    const float s = self->calibration.parameters.afr_stoichiometric, mean = self->afr.mean_lambda;
    const float of_lambda = 1.0f - mean / (1.0f + s); /* more fuel is more gas, too */
    float trim[SD_BALANCE_CYLINDERS_MAX] = { 0.0f };
    for (uint32_t i = 0; i < self->balance.config.cylinders; ++i) { trim[i] = of_lambda * self->fuel_trim[i] / (1.0f + self->fuel_trim[i]); }
    const sd_afr_trims_t cycle = { .speed_radps = speed_radps, .trim = trim, .mean_lambda = mean, .steady = steady ? 1u : 0u };
    (void)sd_afr_delay_cycle(&self->afr_delay, &cycle);
}

/* A loop that ran with a wrong phase begins anew with the right one. */
static void take_over(sd_ecu_t *self, float speed_radps, const sd_afr_learned_t *learned) {
    const sd_parameters_t *p = &self->calibration.parameters;
    const float moved = speed_radps * (learned->late_s - self->afr.known.late_s);
    sd_afr_learned_t known = *learned; /* what the calibration is sure of nobody need learn */
    if (!(known.late_sd_s < p->afr_late_error_s)) { known.late_sd_s = p->afr_late_error_s; }
    if (!(known.lag_sd < p->afr_lag_error)) { known.lag_sd = p->afr_lag_error; }
    sd_afr_correct(&self->afr, &known);
    if ((moved > -MENDED_RAD) && (moved < MENDED_RAD)) { return; }
    sd_afr_restart(&self->afr);
    sd_balance_resume(&self->balance);
}

static bool wants_probe(const sd_ecu_t *self, float speed_radps) {
    return (self->calibration.parameters.afr_identify > 1.5f) && (self->probe_done == 0u) && (self->afr.slow == 0u) &&
           ((self->balance.diverged != 0u) ||
            ((self->balance.learned > PROBE_AFTER) && (self->afr_delay.learned.late_sd_s * speed_radps > KNOWN_RAD)));
}

void sd_ecu_delay_cycle(sd_ecu_t *self, float speed_radps, bool moves) {
    sd_afr_delay_t *delay = &self->afr_delay;
    const bool on = (self->sample[SD_INPUT_BALANCE_ENABLE].value > 0.5f) && (self->calibration.parameters.balance_source > 0.5f);
    const bool steady = !moves && (self->crank.phase_votes >= 2u) && (sd_afr_status(&self->afr).health != SD_INVALID);
    if ((delay->config.cylinders == 0u) || (self->calibration.parameters.afr_identify < 0.5f)) {
        sd_afr_delay_probe(delay, false);
        take_over(self, speed_radps, &(sd_afr_learned_t){ .late_sd_s = 1.0f, .lag_sd = 1.0f });
        return;
    }
    const bool probed = delay->probed != 0u;
    learn(self, speed_radps, steady);
    take_over(self, speed_radps, &delay->learned);
    if (!on) { self->probe_done = 0; }
    if (probed && (delay->probed == 0u)) { self->probe_done = 1; }
    sd_afr_delay_probe(delay, on && steady && ((delay->probed != 0u) || wants_probe(self, speed_radps)));
    self->signals.afr_late_s = delay->learned.late_s;
    self->signals.afr_late_sd_s = delay->learned.late_sd_s;
    self->signals.afr_lag = delay->learned.lag;
    self->signals.afr_probing = (delay->probed != 0u) ? 1.0f : 0.0f;
}
