/* SPDX-License-Identifier: MIT */
/* The misfire monitor: any bits in state and firings, NaN included; any configuration offered to init. */
/* options: -eva-precision 0 -eva-slevel 300 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/misfire/sd_misfire.c */
#include "any.h"
#include "sd_misfire.h"

static sd_misfire_t self;

static void fill_state(void) {
    ANY_BYTES(self);
    self.config.cylinders = (uint8_t)any_of(1, SD_MISFIRE_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_MISFIRE_CYLINDERS_MAX; i++) { self.config.firing_order[i] = (uint8_t)any_of(1, SD_MISFIRE_CYLINDERS_MAX); }
}

int main(void) {
    sd_misfire_firing_t firing;
    sd_misfire_verdict_t verdict;
    sd_misfire_config_t config;
    sd_misfire_report_t report;
    ANY_BYTES(firing), ANY_BYTES(verdict), ANY_BYTES(config);
    verdict.cylinder = (uint8_t)any_of(1, SD_MISFIRE_CYLINDERS_MAX);
    verdict.firing = (uint8_t)any_upto(SD_MISFIRE_CYLINDERS_MAX - 1u);
    fill_state();
    (void)sd_misfire_judge(&self, &firing);
    fill_state();
    sd_misfire_count(&self, &verdict);
    fill_state();
    (void)sd_misfire_status(&self);
    sd_misfire_read(&self, &report);
    sd_misfire_start(&self);
    (void)sd_misfire_configure(&self, &config);
    (void)sd_misfire_init(&self, &config);
    return 0;
}
