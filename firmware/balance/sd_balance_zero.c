/* SPDX-License-Identifier: MIT */
#include "sd_balance_zero.h"

enum { SETTLED = 10, CYCLES_MAX = 64 };

#define TORQUE_MAX_NM 1e6f

void sd_balance_zero_step(sd_balance_zero_t *self, const float *torque_nm, uint32_t cylinders, float intake_bar, bool motored) {
    bool usable = motored && (cylinders >= 1u) && (cylinders <= SD_BALANCE_CYLINDERS_MAX) && (intake_bar > 0.0f);
    float mean = 0.0f;
    for (uint32_t i = 0; usable && (i < cylinders); ++i) {
        usable = (torque_nm[i] > -TORQUE_MAX_NM) && (torque_nm[i] < TORQUE_MAX_NM);
        mean += torque_nm[i] / (float)cylinders;
    }
    self->motored = usable ? (uint16_t)(self->motored + ((self->motored < SETTLED) ? 1u : 0u)) : 0u;
    if (self->motored < SETTLED) { return; }
    if (self->cycles < CYCLES_MAX) { self->cycles++; }
    for (uint32_t i = 0; i < cylinders; ++i) {
        self->nm_per_bar[i] += ((torque_nm[i] - mean) / intake_bar - self->nm_per_bar[i]) / (float)self->cycles;
    }
}

float sd_balance_zero_nm(const sd_balance_zero_t *self, uint32_t cylinder, float intake_bar) {
    if ((self->cycles == 0u) || (cylinder >= SD_BALANCE_CYLINDERS_MAX) || !(intake_bar > 0.0f)) { return 0.0f; }
    return self->nm_per_bar[cylinder] * intake_bar;
}
