/* SPDX-License-Identifier: MIT */
/* What the filter on tooth times takes for tables and for choices. */
#include "sd_kalman.h"

static bool all_within(const float *values, uint32_t count, float from, float to) {
    for (uint32_t i = 0; i < count; ++i) {
        if (!((values[i] >= from) && (values[i] <= to))) { return false; } /* NaN is out of range */
    }
    return true;
}

static bool sizes_ok(const sd_kalman_tables_t *t) {
    if ((t->positions < 12u) || (t->positions > SD_KALMAN_POSITIONS_MAX) || (t->positions % 2u != 0u)) { return false; }
    if ((t->coefficients < 1u) || (t->coefficients > SD_KALMAN_COEFFICIENTS_MAX)) { return false; }
    if ((t->speeds < 1u) || (t->speeds > SD_KALMAN_SPEEDS_MAX) || (t->sets < 1u) || (t->sets > SD_KALMAN_SETS_MAX)) { return false; }
    if (sd_kalman_pool_used(t) > SD_KALMAN_POOL) { return false; }
    if ((t->cylinders < 1u) || (t->cylinders > SD_KALMAN_FIRINGS_MAX) || (t->firings > t->cylinders) || (t->firings >= t->coefficients)) { return false; }
    if ((t->shapes > 1u) || ((t->shapes > 0u) && (t->firings == 0u))) { return false; }
    if ((t->modes > SD_KALMAN_MODES_MAX) || ((t->modes > 0u) && (t->firings != t->cylinders))) { return false; }
    for (uint32_t i = 0; i < t->cylinders; ++i) {
        if ((t->read_position[i] >= 2u * t->positions) || (t->close_position[i] >= 2u * t->positions)) { return false; }
    }
    for (uint32_t i = 1; i < t->speeds; ++i) {
        if (!(t->speed_radps[i] > t->speed_radps[i - 1u])) { return false; }
    }
    return true;
}

static bool mode_ok(const sd_kalman_mode_t *mode) {
    return all_within(&mode->frequency_radps, 1u, 1.0f, 1e5f) && all_within(&mode->damping, 1u, 0.0f, 0.99f) &&
           all_within(&mode->constant_radpnm, 1u, -1.0f, 1.0f) && all_within(&mode->spring_nmprad, 1u, -1e7f, 1e7f) &&
           all_within(mode->cylinder_radpnm, SD_KALMAN_FIRINGS_MAX, -1.0f, 1.0f) && all_within(&mode->damper_nmprad, 1u, -1e7f, 1e7f);
}

bool sd_kalman_tables_ok(const sd_kalman_tables_t *t) {
    if (!sizes_ok(t)) { return false; }
    const uint32_t n = t->positions, gains = (uint32_t)t->sets * t->speeds;
    bool ok = all_within(&t->tick_hz, 1u, 1e5f, 2e8f) &&
              all_within(&t->shape_min_nm, 1u, 0.0f, 2e4f) && all_within(&t->inertia_mean_kgm2, 1u, 1e-6f, 10.0f) &&
              all_within(t->inertia_tooth_kgm2, n, 1e-6f, 10.0f) && all_within(t->inertia_interval_kgm2, n, 1e-6f, 10.0f) &&
              all_within(t->speed_radps, t->speeds, 1.0f, 2000.0f) && all_within(t->noise_rad, gains, 1e-7f, 1.0f) &&
              all_within(t->innovation, gains, 1.0f, 1e3f) && all_within(t->single_sd, gains, 0.0f, 1e6f) &&
              all_within(t->mean_sd, gains, 0.0f, 1e6f) && all_within(t->pattern_sd, gains, 0.0f, 1e6f) &&
              all_within(t->load_sd_nm, gains, 0.0f, 1e6f) && all_within(t->mean_share, gains, 0.0f, 10.0f) &&
              all_within(t->spread_share, gains, 0.0f, 10.0f) && all_within(t->charge_nm_per_bar, gains, 0.0f, 1e4f) &&
              all_within(t->learned_nm_per_bar, gains, 0.0f, 1e4f);
    for (uint32_t which = 0; ok && (which < 3u); ++which) { ok = all_within(t->known[which], 2u * n, -1e5f, 1e5f); }
    for (uint32_t m = 0; ok && (m < t->modes); ++m) { ok = mode_ok(&t->mode[m]); }
    return ok && all_within(t->pool, sd_kalman_pool_used(t), -1e6f, 1e6f);
}

bool sd_kalman_choice_ok(const sd_kalman_choice_t *choice) {
    return all_within(&choice->torque_base_nm, 1u, 1e-3f, 2e4f) && all_within(&choice->reject_rad, 1u, 1e-6f, 1.0f);
}
