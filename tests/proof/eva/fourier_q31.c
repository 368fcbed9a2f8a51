/* SPDX-License-Identifier: MIT */
/* The torque observer in q31: any state, tables and gains in range, any tooth. */
/* options: -eva-precision 0 -eva-slevel 100 */
/* kernel: firmware/torque/sd_fourier_q31.c */
#include "any_q31.h"
#include "sd_fourier.h"

#ifndef FIRST
#define FIRST 12u
#define LAST SD_FOURIER_POSITIONS_MAX
#define STEP 2u
#endif
static volatile float kept;
static sd_fourier_q31_t self;
static sd_fourier_tables_t tables;

static void fill_state(void) {
    ANY_BYTES(self);
    self.harmonics = (uint8_t)any_of(1, SD_FOURIER_HARMONICS_MAX);
    self.period_base_ticks = 16u + any_upto(UINT32_MAX - 16u);
    self.energy_base_j = self.torque_base_nm = 1.0f; /* carried, not used by a step's arithmetic */
    self.to_energy = any_gain(), self.gain_energy = any_gain(), self.gain_mean = any_gain(), self.gain_reference = any_gain();
}

static void call_all(void) {
    sd_fourier_estimate_t estimate;
    sd_fourier_advance_q31(&self, &tables, any_u32(), any_u32(), any_u32(), (uint8_t)any_upto(1u));
    kept = sd_fourier_torque_at_q31(&self, &tables, any_u32());
    sd_fourier_shift_revolution_q31(&self);
    sd_fourier_read_q31(&self, &estimate);
    (void)sd_fourier_status_q31(&self);
    (void)sd_fourier_health_q31(&self);
    sd_fourier_restart_q31(&self);
}

static void fill_tables(void) {
    for (uint32_t k = 0; k < SD_FOURIER_POSITIONS_MAX; k++) { tables.inertia_q31[k] = any_of(1, INT32_MAX); }
    for (uint32_t k = 0; k < 2u * SD_FOURIER_POSITIONS_MAX; k++) { tables.sine_q31[k] = any_sine(); }
}

/* The place where the sine is -1 exactly, which as q31 is INT32_MIN: the cosine there is within the table's tolerance of 0. */
static void at_minus_one(uint32_t positions) {
    const uint32_t low = positions + positions / 2u;
    fill_state();
    self.positions = (uint16_t)positions;
    tables.sine_q31[low] = INT32_MIN;
    tables.sine_q31[0] = any_of(-(1 << 22), 1 << 22);
    kept = sd_fourier_torque_at_q31(&self, &tables, low);
    sd_fourier_advance_q31(&self, &tables, low, 1u, any_u32(), 1u);
    tables.sine_q31[low] = any_sine(), tables.sine_q31[0] = any_sine();
}

int main(void) {
    fill_tables();
    //@ loop unroll 60;
    for (uint32_t positions = FIRST; positions <= LAST; positions += STEP) {
        fill_state();
        self.positions = (uint16_t)positions;
        call_all();
        if (positions % 12u == 0u) { at_minus_one(positions); }
    }
    return 0;
}
