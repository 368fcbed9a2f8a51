/* SPDX-License-Identifier: MIT */
#include "sd_stage_trims.h"

#include <string.h>

#include "sd_math.h"

#define TORQUE_FOLLOWS 0.5f /* a cycle: half of the firings that a cycle reads were injected before it began */
#define BURNS_NM       1.0f /* mean torque of the cylinders below which nothing burns */

static sd_balance_config_t config_of(const sd_calibration_t *page, const sd_parameters_t *p) {
    return (sd_balance_config_t){ .cylinders = page->cylinders, .gain = p->balance_integral_gain,
                                  .proportional = p->balance_proportional_gain, .rate = p->balance_trim_rate,
                                  .limit = p->balance_trim_limit, .sd_max = p->balance_sd_max,
                                  .hold_cycles = (uint16_t)p->balance_hold_cycles };
}

sd_result_t sd_stage_trims_init(sd_stage_trims_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_balance_config_t config = config_of(page, p);
    sd_balance_t balance;
    memset(&balance, 0, sizeof balance);
    /* One cylinder has nothing to be balanced with. */
    if ((config.cylinders > 1u) && (sd_balance_init(&balance, &config) != SD_OK)) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->balance = balance;
    return SD_OK;
}

sd_result_t sd_stage_trims_configure(sd_stage_trims_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_balance_config_t config = config_of(page, p);
    return (config.cylinders < 2u) ? SD_OK : sd_balance_configure(&self->balance, &config);
}

void sd_stage_trims_restart(sd_stage_trims_t *self) { sd_balance_restart(&self->balance); }

void sd_stage_trims_firing(sd_stage_trims_t *self, const sd_firing_t *firing, uint8_t health, bool misfired) {
    sd_cycle_firings_t *cycle = &self->running;
    cycle->torque_nm[firing->index] = firing->torque_nm;
    cycle->sd_nm[firing->index] = firing->sd_nm;
    if (health > cycle->health) { cycle->health = health; }
    if (misfired) { cycle->misfired = 1; }
    cycle->count++;
}

void sd_stage_trims_end_cycle(sd_stage_trims_t *self) {
    self->ended = self->running;
    self->running.count = self->running.health = self->running.misfired = 0;
}

void sd_stage_trims_by_torque(const sd_stage_trims_t *self, uint32_t cylinders, sd_deviations_t *out) {
    const sd_cycle_firings_t *firings = &self->ended;
    float mean = 0.0f;
    memset(out, 0, sizeof *out);
    out->follow = TORQUE_FOLLOWS;
    out->health = SD_INVALID;
    for (uint32_t i = 0; i < cylinders; ++i) { mean += firings->torque_nm[i] / (float)cylinders; }
    if ((firings->count < cylinders) || !(mean > BURNS_NM)) { return; }
    for (uint32_t i = 0; i < cylinders; ++i) {
        out->value[i] = firings->torque_nm[i] / mean - 1.0f;
        out->sd[i] = firings->sd_nm[i] / mean;
    }
    out->health = firings->health;
}

void sd_stage_trims_begin(sd_stage_trims_t *self, sd_trims_wish_t wish, const sd_deviations_t *deviations, bool transient) {
    if (wish == SD_TRIMS_OFF) {
        sd_balance_restart(&self->balance);
        return;
    }
    const sd_balance_input_t in = { .deviation = deviations->value, .sd = deviations->sd, .follow = deviations->follow,
                                    .told = deviations->told,
                                    .health = (wish == SD_TRIMS_FREEZE) ? (uint8_t)SD_INVALID : deviations->health,
                                    .transient = transient ? 1u : 0u };
    sd_balance_begin(&self->balance, &in);
}

bool sd_stage_trims_work(sd_stage_trims_t *self) { return sd_balance_work(&self->balance); }

void sd_stage_trims_command(sd_stage_trims_t *self, const float *probe, float limit) {
    for (uint32_t i = 0; i < self->balance.config.cylinders; ++i) {
        self->trim[i] = sd_clamp(self->balance.trim[i] + probe[i], -limit, limit);
    }
}
