/* SPDX-License-Identifier: MIT */
#include "sd_driveline_tables.h"

bool sd_driveline_tables_ok(const sd_driveline_tables_t *t) {
    bool ok = sd_bits_above_to(t->tick_s, 0.0f, 1e-3f) && sd_bits_above_to(t->pitch_rad, 0.0f, 0.6f) &&
              sd_bits_within(t->wheel_pitch_rad, 0.0f, 3.2f) && sd_bits_above_to(t->shortest_s, 0.0f, 1.0f) &&
              sd_bits_above_to(t->per_inertia, 0.0f, 1e4f) && sd_bits_within(t->viscous_nms, 0.0f, 100.0f) &&
              sd_bits_above_to(t->per_vehicle, 0.0f, 1e4f) && sd_bits_within(t->soft_nmprad, 0.0f, 1e7f) &&
              sd_bits_within(t->stiff_nmprad, 1.0f, 1e7f) && sd_bits_within(t->damping_nms, 0.0f, 1e6f) &&
              sd_bits_above_to(t->kink_rad, 0.0f, 1.0f) && sd_bits_within(t->rolling_nm, 0.0f, 1e5f) &&
              sd_bits_within(t->drag_nms2, 0.0f, 1e4f) && sd_bits_above_to(t->reject_rad, 0.0f, 1.0f) &&
              sd_bits_within(t->per_reject, 1.0f, 1e9f) && sd_bits_above_to(t->doubt_rad, 0.0f, 1.0f) &&
              sd_bits_within(t->settle_s, 0.0f, 100.0f) && sd_bits_within(t->moving_radps, 0.0f, 1e6f) &&
              sd_bits_within(t->moving_hold_s, 0.0f, 100.0f) && (t->gears <= SD_DRIVELINE_GEARS_MAX) &&
              (t->guard <= (uint8_t)SD_GUARD_TORQUE);
    for (uint32_t g = 0; ok && (g < t->gears); ++g) { ok = sd_bits_above_to(t->gear[g].ratio, 0.0f, 2.0f); }
    return ok;
}
