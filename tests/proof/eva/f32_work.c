/* SPDX-License-Identifier: MIT */
/* Work of a cycle in f32: any bits in state and windows, NaN included. */
/* options: -eva-precision 0 -eva-slevel 60 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/torque/sd_work.c firmware/torque/sd_work_f32.c */
#include "any.h"
#include "sd_work.h"

enum { TICKS_MOST = 0x3fffffff };

static sd_work_meter_t self;
static sd_work_tables_t tables;
static sd_work_out_t out;

int main(void) {
    ANY_BYTES(tables), ANY_BYTES(self);
    tables.windows = (uint8_t)any_of(1, SD_WORK_WINDOWS_MAX);
    self.at = (uint8_t)any_upto(SD_WORK_WINDOWS_MAX - 1u);
    self.ticks = any_upto(TICKS_MOST), self.last_ticks = any_upto(TICKS_MOST); /* work_q31.c has that edges keep them so */
    sd_work_read_f32(&self, &tables, any_number(), &out);
    return 0;
}
