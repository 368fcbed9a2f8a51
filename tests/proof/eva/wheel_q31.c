/* SPDX-License-Identifier: MIT */
/* Document 000's observers on the toothed wheel in q31: any state, tables in range, any tooth and firing. */
/* options: -eva-slevel 100 */
/* kernel: firmware/misfire/sd_switched_q31.c firmware/misfire/sd_switched_wheel_q31.c */
#include "any_q31.h"
#include "sd_switched_wheel.h"

static sd_wheel_q31_t self;
static sd_wheel_tables_t tables;

static void fill_tables(uint32_t positions) {
    ANY_BYTES(tables);
    tables.positions = (uint8_t)positions;
    tables.cylinders = (uint8_t)any_of(1, SD_CYLINDERS_MAX);
    tables.speed_shift = (uint8_t)any_of(0, 24);
    sd_wheel_tables_q31_t *t = &tables.q31;
    for (uint32_t kind = 0; kind < SD_WHEEL_KINDS; kind++) {
        sd_wheel_design_q31_t *design = &t->design[kind];
        design->table.row[0] = any_row(), design->table.row[1] = any_row();
        design->table.output_gain = any_gain(), design->table.slope = any_gain();
        design->table.reduced = any_upto(1u);
        design->sliding = any_size_gain(), design->capture = any_size_gain();
        for (uint32_t k = 0; k < 2u * SD_WHEEL_POSITIONS_MAX; k++) { tables.mark[kind][k] = any_u16(); }
    }
    t->pulse = any_gain(), t->mean = any_gain(), t->jump = any_gain();
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; i++) { t->accel[i] = any_size_gain(), t->per_tooth[i] = any_gain(); }
    for (uint32_t k = 0; k < SD_WHEEL_POSITIONS_MAX; k++) { tables.inertia_q31[k] = any_q31(); }
}

static void fill_state(uint32_t kind) {
    ANY_BYTES(self);
    self.observer.sliding = any_of(0, INT32_MAX);
    self.open = (uint8_t)any_of(0, SD_CYLINDERS_MAX);
    self.config = (sd_wheel_config_q31_t){ .definition = any_q31(), .work_min = any_q31(), .speed_change = any_q31(),
                                           .start_firings = any_u16(), .hold_firings = any_u16(), .kind = (uint8_t)kind };
}

static void call_all(void) {
    const sd_wheel_tooth_t tooth = { any_u16(), any_u16(), any_u32(), any_upto(1u) };
    const uint32_t reads = sd_wheel_tooth_q31(&self, &tables, &tooth, any_q31());
    //@ assert reads: reads <= 15;
    const sd_wheel_config_q31_t config = { any_q31(), any_q31(), any_q31(), any_u16(), any_u16(), (uint8_t)any_upto(255u) };
    (void)sd_wheel_configure_q31(&self, &config);
    (void)sd_wheel_init_q31(&self, &config, &tables);
    sd_wheel_restart_q31(&self);
}

/* Firings whose work is known, and such whose work is not. */
static void judge(uint32_t kind) {
    sd_wheel_verdict_q31_t verdict;
    for (int known = 0; known < 2; known++) {
        fill_state(kind);
        for (uint32_t i = 0; i < SD_CYLINDERS_MAX; i++) { self.work[i] = (known != 0) ? any_of(0, INT32_MAX) : any_of(INT32_MIN, -1); }
        sd_wheel_judge_q31(&self, &tables, any_u32(), any_upto(255u), &verdict);
        //@ assert firing: verdict.firing < SD_CYLINDERS_MAX;
    }
}

/* The same observer alone, as the benches of document 000 run it. */
static void call_switched(void) {
    sd_switched_q31_t observer;
    const sd_switched_table_q31_t table = { { any_row(), any_row() }, any_gain(), any_gain(), any_upto(1u) };
    ANY_BYTES(observer);
    sd_switched_start_q31(&observer, &table, any_q31(), any_q31(), any_q31());
    ANY_BYTES(observer);
    observer.sliding = any_of(0, INT32_MAX);
    (void)sd_switched_step_q31(&observer, &table, any_q31(), any_q31());
    (void)sd_switched_coast_q31(&observer, &table, any_q31());
    (void)sd_switched_error_q31(&observer, &table);
}

int main(void) {
    call_switched();
    for (uint32_t positions = 12; positions <= SD_WHEEL_POSITIONS_MAX; positions += 108u) { /* 12, 120 */
        fill_tables(positions);
        const uint32_t kind = any_upto(SD_WHEEL_KINDS - 1u);
        fill_state(kind);
        call_all();
        judge(kind);
    }
    return 0;
}
