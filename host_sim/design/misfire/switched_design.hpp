// SPDX-License-Identifier: MIT
// Exact steps for the observers of document 000: matrix exponentials, computed here so that no target needs them.
#pragma once

extern "C" {
#include "sd_plant_step.h"
}

namespace sixdeg {

/// v1' = v2, v2' = -k2 v2 - k1 v1 + C Q.
struct CrankModel {
    double k1_per_s2, k2_per_s;
};

/// The plant itself: what the per-cylinder-input observer predicts with.
sd_plant_step_t plant_step(const CrankModel &model, double period_s, double tick_hz);
/// FOLSMO; FOSMO with luenberger_per_s2 (L) = 0.
sd_plant_step_t folsmo_step(const CrankModel &model, double luenberger_per_s2, double period_s, double tick_hz);
/// ROO with gain l.
sd_plant_step_t roo_step(const CrankModel &model, double gain_per_s, double period_s, double tick_hz);

} // namespace sixdeg
