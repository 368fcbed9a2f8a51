/* SPDX-License-Identifier: MIT */
/* Reading of a firing from the filter on tooth times: its torque, and how far each of the doubts about it goes. */
#include "sd_kalman_firing.h"

/* Puts a torque among the cylinder's last ones and returns their mean. */
static float remember(sd_kalman_filter_t *f, uint32_t i, float torque_nm) {
    const uint32_t place = f->next[i], next = place + 1u, before = f->kept[i],
        kept = (before < SD_KALMAN_MEAN) ? before + 1u : SD_KALMAN_MEAN;
    f->ring_nm[i][place] = torque_nm;
    f->next[i] = (uint8_t)((next < SD_KALMAN_MEAN) ? next : 0u);
    f->kept[i] = (uint8_t)kept;
    float sum = 0.0f;
    for (uint32_t j = 0; j < kept; ++j) { sum += f->ring_nm[i][j]; }
    return sum / (float)kept;
}

/* Variance of a firing less the mean of all (of one cylinder, of the firing), from what is not known of the engine. */
static float model_variance(const sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_filter_t *f, sd_between_t at,
                            uint32_t i) {
    const float mean = sd_kalman_sum_firings(f, t) / (float)t->firings;
    float spread = 0.0f;
    for (uint32_t j = 1; j <= t->firings; ++j) {
        const float apart = f->motion.coefficient_nm[j] - mean;
        spread += apart * apart / (float)t->firings;
    }
    const float of_mean = sd_kalman_blend(t->mean_share, at), of_spread = sd_kalman_blend(t->spread_share, at);
    /* One cylinder has no zero beside the exponent, which takes what it reads in fuel cut. */
    const bool learned = (self->zero_nm_per_bar[i] != 0.0f) || ((t->firings == 1u) && (self->charge.exponent != 0.0f));
    const float *doubt_nm_per_bar = learned ? t->learned_nm_per_bar : t->charge_nm_per_bar;
    const float of_charge = sd_kalman_blend(doubt_nm_per_bar, at) * self->charge.charge_bar[i];
    return of_mean * of_mean * mean * mean + of_spread * of_spread * spread + of_charge * of_charge;
}

void sd_kalman_read_firing(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, uint32_t i,
                           const sd_kalman_tooth_t *tooth, sd_firing_t *firing) {
    sd_kalman_filter_t *f = &self->filter[which];
    const float square = 2.0f * f->motion.energy_j / t->inertia_mean_kgm2;
    const sd_between_t at = sd_kalman_between(t, which, sd_root(square) * self->tuning.gain_speed);
    const float scale = t->inertia_mean_kgm2 * square, design = sd_kalman_blend(t->noise_rad, at);
    /* Noise as met. A tooth's own error shows in the innovation too, but does not average out. */
    const float total = design * design * f->noise_ratio, fixed = tooth->pattern_rad * tooth->pattern_rad;
    const float fresh = (total > fixed) ? total - fixed : 0.0f;
    firing->index = (uint8_t)i;
    firing->raw_nm = f->motion.coefficient_nm[1u + i];
    firing->torque_nm = firing->raw_nm - self->zero_nm_per_bar[i] * self->charge.charge_bar[i];
    firing->mean_nm = remember(f, i, firing->torque_nm);
    const float single = sd_kalman_blend(t->single_sd, at), mean = sd_kalman_blend(t->mean_sd, at),
        stays = sd_kalman_blend(t->pattern_sd, at);
    const float shrink = (float)SD_KALMAN_MEAN / (float)f->kept[i]; /* variance, taken as independent until it is full */
    const float hidden = scale * tooth->hidden_share, model = model_variance(self, t, f, at, i) + hidden * hidden;
    const float load = (which > 0u) ? sd_kalman_blend(t->load_sd_nm, at) : 0.0f;
    firing->noise_nm = scale * single * ((fresh > design * design) ? sd_root(fresh) : design);
    firing->sd_nm = sd_root(scale * scale * single * single * fresh + scale * scale * stays * stays * fixed + model + load * load);
    firing->mean_sd_nm = sd_root(scale * scale * (mean * mean * fresh * shrink + stays * stays * fixed) + model);
}
