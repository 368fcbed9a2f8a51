/* SPDX-License-Identifier: MIT */
/* The joint filter, the model of the trims that learns the delay, and what comes in: any bits in state and inputs, NaN included. */
/* options: -eva-precision 0 */
/* specified: sd_sqrt_by_bits_f32 */
/* include: contracts_root.h */
/* kernel: firmware/afr/sd_afr_joint.c firmware/afr/sd_afr_delay.c firmware/afr/sd_afr_inflow.c */
#include "any.h"
#include "sd_afr_delay.h"
#include "sd_afr_joint.h"

static sd_afr_joint_t joint;
static sd_afr_delay_t delay;
static sd_afr_inflow_t in;
static float gains[3 + SD_AFR_CYLINDERS_MAX], trim[SD_AFR_CYLINDERS_MAX], variance[SD_AFR_CYLINDERS_MAX];

static void fill(uint32_t cylinders) {
    ANY_BYTES(joint), ANY_BYTES(delay), ANY_BYTES(in);
    joint.config.cylinders = (uint8_t)cylinders;
    joint.group = (uint8_t)(SD_AFR_GROUP * any_of(1, 2));
    joint.positions = (uint8_t)any_upto(2 * SD_AFR_GROUP - 1);
    joint.samples = (uint8_t)any_upto(2 * SD_AFR_GROUP - 1);
    delay.config.cylinders = (uint8_t)cylinders;
    delay.config.tau1_s = any_float(1e-4f, 1.0f), delay.config.tau2_s = any_float(1e-4f, 1.0f);
    delay.config.cycle_positions = (uint16_t)any_of(24, SD_AFR_POSITIONS_MAX);
    in.count = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_AFR_CYLINDERS_MAX; i++) { in.cylinder[i] = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX - 1u); }
}

static void call_joint(uint32_t cylinders, float any) {
    sd_afr_joint_config_t config;
    sd_afr_usual_t usual;
    ANY_BYTES(config), ANY_BYTES(usual);
    fill(cylinders);
    sd_afr_joint_step(&joint, &in, any, any_bool() ? gains : 0);
    fill(cylinders);
    sd_afr_joint_set(&joint, any, any, any);
    sd_afr_joint_move(&joint, any_u32(), any);
    (void)sd_afr_joint_lambda(&joint, any_u32());
    sd_afr_joint_deviation_variances(&joint, variance);
    (void)sd_afr_joint_blame(&joint, &usual);
    for (uint32_t row = 0; row < SD_AFR_CYLINDERS_MAX + 4u; row++) {
        for (uint32_t column = 0; column < SD_AFR_CYLINDERS_MAX + 4u; column++) { (void)sd_afr_joint_covariance(&joint, row, column); }
    }
    (void)sd_afr_joint_status(&joint);
    sd_afr_joint_restart(&joint);
    (void)sd_afr_joint_init(&joint, &config);
}

static void call_delay(uint32_t cylinders, float any) {
    sd_afr_delay_config_t config;
    sd_afr_learned_t learned;
    const sd_afr_trims_t cycle = { any, trim, any, (uint8_t)any_upto(1u) };
    ANY_BYTES(config), ANY_BYTES(learned);
    fill(cylinders);
    sd_afr_delay_step(&delay, &in, any_u32(), any);
    fill(cylinders);
    (void)sd_afr_delay_cycle(&delay, &cycle);
    sd_afr_delay_probe(&delay, any_bool());
    (void)sd_afr_delay_probe_trim(&delay, any_u32());
    (void)sd_afr_delay_doubt(&learned, any, any, any);
    sd_afr_delay_restart(&delay);
    (void)sd_afr_delay_init(&delay, &config);
}

int main(void) {
    sd_exhaust_now_f32_t now;
    float any;
    any = any_number();
    ANY_BYTES(gains), ANY_BYTES(trim), ANY_BYTES(now);
    now.count = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX);
    for (uint32_t i = 0; i < SD_AFR_CYLINDERS_MAX; i++) { now.flowing[i] = (uint8_t)any_upto(SD_AFR_CYLINDERS_MAX - 1u); }
    sd_afr_inflow_of(&now, &in);
    for (uint32_t n = 1; n <= SD_AFR_CYLINDERS_MAX; n++) { call_joint(n, any); }
    for (uint32_t n = 2; n <= SD_AFR_CYLINDERS_MAX; n++) { call_delay(n, any); }
    return 0;
}
