/* SPDX-License-Identifier: MIT */
/* What the filter on tooth times takes for tables and for choices. */
#include "sd_kalman.h"

static bool sizes_ok(const sd_kalman_tables_t *t) {
    if ((t->positions < 12u) || (t->positions > SD_KALMAN_POSITIONS_MAX) || (t->positions % 2u != 0u)) { return false; }
    if ((t->coefficients < 1u) || (t->coefficients > SD_KALMAN_COEFFICIENTS_MAX)) { return false; }
    if ((t->speeds < 1u) || (t->speeds > SD_KALMAN_SPEEDS_MAX) || (t->sets < 1u) || (t->sets > SD_KALMAN_SETS_MAX)) { return false; }
    if ((t->cylinders < 1u) || (t->cylinders > SD_KALMAN_FIRINGS_MAX) || (t->firings > t->cylinders) ||
        (t->firings >= t->coefficients)) { return false; }
    if ((t->shapes > 1u) || ((t->shapes > 0u) && (t->firings == 0u))) { return false; }
    if ((t->modes > SD_KALMAN_MODES_MAX) || ((t->modes > 0u) && ((t->firings != t->cylinders) ||
        (t->coefficients != t->cylinders + 1u)))) { return false; }
    if ((t->window >= t->coefficients) || (t->teeth < 4u) || (t->teeth > t->positions)) { return false; }
    if ((t->parts != 0u) && ((t->firings == 0u) || (t->modes > 0u) || (t->parts != t->firings + 3u))) { return false; }
    if ((t->hidden > SD_KALMAN_HIDDEN_MAX) || ((t->hidden > 0u) && (t->parts == 0u))) { return false; }
    if ((t->row_words != sd_motion_row_words(t)) || (t->gains_at != sd_motion_gains_at(t))) { return false; }
    return sd_kalman_pool_used(t) <= SD_KALMAN_POOL;
}

static bool mode_ok(const sd_kalman_mode_t *mode) {
    return sd_within(mode->frequency_radps, 1.0f, 1e5f) && sd_within(mode->damping, 0.0f, 0.99f) &&
           sd_within(mode->constant_radpnm, -1.0f, 1.0f) && sd_all_within(mode->cylinder_radpnm, SD_KALMAN_FIRINGS_MAX, -1.0f, 1.0f) &&
           sd_within(mode->spring_nmprad, -1e7f, 1e7f) && sd_within(mode->damper_nmprad, -1e7f, 1e7f);
}

static bool speeds_ok(const sd_kalman_tables_t *t) {
    bool ok = sd_all_within(t->speed_radps, t->speeds, 1.0f, 2000.0f);
    for (uint32_t i = 1; ok && (i < t->speeds); ++i) { ok = t->speed_radps[i] > t->speed_radps[i - 1u]; }
    return ok;
}

static bool gains_ok(const sd_kalman_tables_t *t) {
    const uint32_t gains = (uint32_t)t->sets * t->speeds;
    return sd_all_within(t->gain_scale[0], SD_KALMAN_SETS_MAX * SD_KALMAN_SCALES, 0.0f, 1e4f) &&
           sd_all_within(t->noise_rad, gains, 1e-7f, 1.0f) && sd_all_within(t->expected_rad, gains, 1e-7f, 1e3f) &&
           sd_all_within(t->single_sd, gains, 0.0f, 1e6f) && sd_all_within(t->mean_sd, gains, 0.0f, 1e6f) &&
           sd_all_within(t->pattern_sd, gains, 0.0f, 1e6f) && sd_all_within(t->load_sd_nm, gains, 0.0f, 1e6f) &&
           sd_all_within(t->mean_share, gains, 0.0f, 10.0f) && sd_all_within(t->spread_share, gains, 0.0f, 10.0f) &&
           sd_all_within(t->charge_nm_per_bar, gains, 0.0f, 1e4f) && sd_all_within(t->learned_nm_per_bar, gains, 0.0f, 1e4f);
}

/* Any 16 bits are a gain, or an entry of a column. */
static bool row_ok(const sd_kalman_tables_t *t, const sd_kalman_word_t *word) {
    const uint32_t cylinders = (1u << t->cylinders) - 1u;
    bool ok = (word[SD_ROW_AT].at.first + 1u < t->coefficients) || (t->window == 0u);
    ok = ok && ((word[SD_ROW_AT].at.close & ~cylinders) == 0u) && (word[SD_ROW_AT].at.read <= t->firings) &&
        (word[SD_ROW_AT].at.tooth <= 1u);
    ok = ok && sd_within(word[SD_ROW_INTERVAL].value, 0.1f, 1e7f) && sd_within(word[SD_ROW_TOOTH].value, 0.1f, 1e7f);
    for (uint32_t i = SD_ROW_KNOWN; ok && (i < t->gains_at); ++i) { ok = sd_within(word[i].value, -1e6f, 1e6f); }
    return ok;
}

bool sd_kalman_tables_ok(const sd_kalman_tables_t *t) {
    if (!sizes_ok(t)) { return false; }
    bool ok = sd_within(t->tick_hz, 1e5f, 2e8f) && sd_within(t->shape_min_nm, 0.0f, 2e4f) &&
              sd_within(t->inertia_mean_kgm2, 1e-6f, 10.0f) &&
              sd_within(t->pitch_rad * (float)t->positions, 0.99f * SD_TWO_PI, 1.01f * SD_TWO_PI) && speeds_ok(t) && gains_ok(t);
    for (uint32_t m = 0; ok && (m < t->modes); ++m) { ok = mode_ok(&t->mode[m]); }
    uint32_t teeth = 0;
    for (uint32_t k = 0; ok && (k < 2u * t->positions); ++k) {
        ok = row_ok(t, sd_motion_word(t, k));
        teeth += sd_motion_word(t, k)[SD_ROW_AT].at.tooth;
    }
    const uint32_t behind_columns = 2u * t->positions * t->row_words + (uint32_t)t->parts * t->positions;
    for (uint32_t i = behind_columns; ok && (i < sd_kalman_pool_used(t)); ++i) {
        ok = sd_within(t->pool[i].value, -1e6f, 1e6f);
    }
    return ok && (teeth == 2u * t->teeth);
}

bool sd_kalman_choice_ok(const sd_kalman_choice_t *choice) {
    return sd_within(choice->torque_base_nm, 1e-3f, 2e4f) && sd_within(choice->reject_rad, 1e-6f, 1.0f);
}
