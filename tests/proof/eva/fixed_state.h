/* SPDX-License-Identifier: MIT */
/// fixed_state.h - page and state of the ecu of fixed point in their ranges, for its drivers. windows: the page has windows of work.
#ifndef SD_PROOF_FIXED_STATE_H
#define SD_PROOF_FIXED_STATE_H
#include "any.h"
#include "contracts_fixed.h"

enum { TICKS_MOST = 0x3fffffff }; /* of a window */
enum { SAMPLES_MOST = 1 << 30 }; /* of a sensor between two teeth */

static sd_ecu_t self;
static sd_calibration_t page;

static uint32_t send(void *context, const sd_event_t *events, uint32_t count) {
    (void)context, (void)events;
    return any_upto(count);
}

/* Of a cycle's work, which sd_fixed_cycle.c alone writes; init begins with piece none, and nothing said. */
/*@ predicate at_rest(sd_ecu_t *s) =
        s->work.piece <= SD_FIXED_NONE && (s->work.part < SD_CYLINDERS_MAX || s->work.piece > SD_FIXED_CYLINDERS) &&
        (s->work.said == 0 || s->work.said == 16 || s->work.said == 32 || s->work.said == 48 || s->work.said == 64); */

/* What sd_calibration_in_range asks for, and init of the decoder. */
static void fill_page(bool windows) {
    ANY_BYTES(page);
    page.positions = (uint8_t)any_of(SD_CRANK_POSITIONS_MIN, SD_CRANK_POSITIONS_MAX);
    page.missing_count = (uint8_t)any_of(1, SD_CRANK_MISSING_MAX);
    page.cylinders = (uint8_t)any_of(1, SD_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; i++) { page.firing_order[i] = (uint8_t)any_of(1, SD_CYLINDERS_MAX); }
    page.cylinder_map.cylinders = (uint8_t)any_upto(SD_CYLINDERS_MAX);
    page.cylinder_map.harmonics = (uint8_t)any_upto(SD_FOURIER_HARMONICS_MAX);
    page.work.windows = (uint8_t)(windows ? any_of(1, SD_WORK_WINDOWS_MAX) : 0), page.work.cycle = windows ? any_u16() : 0u;
    page.wheel.cylinders = (uint8_t)any_of(0, SD_CYLINDERS_MAX);
    page.wheel.accel_exponent = (int8_t)any_of(0, 30), page.wheel.work_exponent = (int8_t)any_of(0, 30);
    page.airpath_q31.period_s = any_of(0, INT32_MAX);
}

static void fill_crank(void) {
    self.crank.now = (uint8_t)any_upto(1u);
    for (uint32_t i = 0; i < 2u; i++) {
        self.crank.clocks[i].leader = any_upto(SD_CRANK_CLOCKS - 1u);
        for (uint32_t j = 0; j < SD_CRANK_CLOCKS; j++) { self.crank.clocks[i].clock[j].change = any_of(-INT32_MAX, INT32_MAX); }
    }
}

static void fill_state(bool windows, uint8_t piece, uint16_t said) {
    const int64_t most = (int64_t)SAMPLES_MOST << 31;
    ANY_BYTES(self);
    fill_crank();
    self.ready = 1;
    self.task = (uint8_t)any_upto(2u);
    self.work.piece = piece, self.work.part = (uint8_t)any_upto(SD_CYLINDERS_MAX - 1u);
    self.work.said = said;
    self.work.cycle = (sd_cycle_t){ any_u32(), any_float(-3e38f, 3e38f), any_bool(), any_bool(), any_bool() };
    self.energy.at = (uint8_t)any_upto(SD_WORK_WINDOWS_MAX - 1u);
    for (uint32_t i = 0; i < SD_WORK_WINDOWS_MAX; i++) { self.energy.passed_ticks[i] = any_upto(TICKS_MOST); }
    if (!windows) { self.energy.waits = UINT16_MAX; } /* sd_work_restart says so */
    self.energy.ticks = any_upto(TICKS_MOST), self.energy.last_ticks = any_upto(TICKS_MOST);
    self.mixture.cycle_positions = (uint16_t)any_of(24, SD_AFR_POSITIONS_MAX); /* read where it runs, and set there by init */
    self.mixture.waiting_first = (uint8_t)any_upto(SD_MIXTURE_WAITING - 1u);
    self.mixture.waiting_count = (uint8_t)any_upto(SD_MIXTURE_WAITING);
    self.mixture.air.sum = Frama_C_long_long_interval(-most, most);
    self.mixture.pressure.sum = Frama_C_long_long_interval(-most, most);
}

#endif
