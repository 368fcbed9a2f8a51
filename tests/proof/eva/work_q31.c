/* SPDX-License-Identifier: MIT */
/* Work of a cycle by integers, and the windows that it shares with f32: any state, any windows in range, any tooth. */
/* options: -eva-precision 0 -eva-slevel 60 */
/* specified: sd_root_q31 sd_reciprocal */
/* include: contracts_bases.h */
/* kernel: firmware/torque/sd_work.c firmware/torque/sd_work_q31.c */
#include "any_q31.h"
#include "sd_work.h"

static sd_work_meter_t self;
static sd_work_tables_t tables;
static sd_work_out_t out;

enum { TICKS_MOST = 0x3fffffff }; /* of a window */

static void fill(void) {
    ANY_BYTES(tables), ANY_BYTES(self);
    tables.windows = (uint8_t)any_of(1, SD_WORK_WINDOWS_MAX);
    self.at = (uint8_t)any_upto(SD_WORK_WINDOWS_MAX - 1u);
    self.ticks = any_upto(TICKS_MOST), self.last_ticks = any_upto(TICKS_MOST);
    for (uint32_t i = 0; i < SD_WORK_WINDOWS_MAX; i++) { self.passed_ticks[i] = any_upto(TICKS_MOST); }
}

int main(void) {
    fill();
    (void)sd_work_edge(&self, &tables, any_u32(), any_u32(), (uint8_t)any_upto(255u));
    //@ assert place: self.at < SD_WORK_WINDOWS_MAX;
    //@ assert ticks: self.ticks <= TICKS_MOST && self.last_ticks <= TICKS_MOST;
    for (uint32_t i = 0; i < SD_WORK_WINDOWS_MAX; i++) {
        //@ assert passed: self.passed_ticks[i] <= TICKS_MOST;
    }
    (void)sd_work_passes(&self, &tables, any_u32(), any_u32());
    fill();
    sd_work_read_q31(&self, &tables, any_float(-3.0e38f, 3.0e38f), &out);
    sd_work_restart(&self, &tables, any_u32());
    //@ assert place: self.at < SD_WORK_WINDOWS_MAX;
    ANY_BYTES(tables);
    (void)sd_work_tables_ok(&tables);
    return 0;
}
