/* SPDX-License-Identifier: MIT */
/* The fuel balance and its watch: any bits in state and estimate, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/balance/sd_balance.c firmware/balance/sd_balance_watch.c */
#include "any.h"
#include "sd_balance.h"

static sd_balance_t self;
static float deviation[SD_BALANCE_CYLINDERS_MAX], sd[SD_BALANCE_CYLINDERS_MAX];

static void fill_state(void) {
    ANY_BYTES(self);
    self.config.cylinders = self.watch.cylinders = (uint8_t)any_of(2, SD_BALANCE_CYLINDERS_MAX);
    self.watch.order = (uint8_t)any_upto(3u);
}

int main(void) {
    sd_balance_config_t config;
    float any;
    ANY_BYTES(deviation), ANY_BYTES(sd), ANY_BYTES(config);
    any = any_number();
    const sd_balance_input_t input = { deviation, sd, any, (uint8_t)any_upto(1u), (uint8_t)any_upto(255u), (uint8_t)any_upto(1u) };
    fill_state();
    sd_balance_begin(&self, &input);
    for (uint32_t work = 0; work < 256u; work += 17u) {
        fill_state();
        self.at_work = (uint8_t)any_upto(255u);
        (void)sd_balance_work(&self);
    }
    (void)sd_balance_status(&self);
    (void)sd_watch_wrong(&self.watch);
    sd_balance_resume(&self);
    sd_balance_restart(&self);
    (void)sd_balance_configure(&self, &config);
    (void)sd_balance_init(&self, &config);
    return 0;
}
