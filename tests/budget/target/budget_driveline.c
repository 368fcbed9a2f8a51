/* SPDX-License-Identifier: MIT */
/* The driveline's two observers, of the canonical driveline at 2000 rpm with torque up and down, so that every location is met. */
#include "board.h"
#include "budget_blocks.h"
#include "sd_driveline_guard.h"
#include "sd_driveline_hybrid.h"

static volatile float   kept;
static volatile int32_t kept_q31;

static sd_driveline_tables_t tables = {
    .tick_s = 1e-6f, .pitch_rad = 0.10471976f, .shortest_s = 1.22e-4f, .per_inertia = 5.9f, .viscous_nms = 0.05f, .per_vehicle = 7.7e-3f,
    .soft_nmprad = 2400.0f, .stiff_nmprad = 8000.0f, .damping_nms = 90.0f, .kink_rad = 0.015f, .rolling_nm = 48.0f, .drag_nms2 = 0.012f,
    .reject_rad = 0.035f, .per_reject = 28.6f, .doubt_rad = 1.0f, .settle_s = 0.5f, .moving_radps = 0.05f, .moving_hold_s = 0.25f,
        .gears = 1u };

static void fill_gear(void) {
    tables.gear[0].ratio = 0.125f;
    for (uint32_t i = 0; i < SD_DRIVELINE_OCTAVES; i++) {
        const sd_driveline_gain_t gain = { { 0.04f, 0.3f, 1e-4f, 1e-4f, 0.02f, 0.0f } };
        tables.gear[0].tooth[0][i] = tables.gear[0].tooth[1][i] = tables.gear[0].start[0][i] = tables.gear[0].start[1][i] = gain;
    }
}

static uint32_t count_guard_f32(uint32_t not_counted, uint32_t regular) {
    static sd_driveline_guard_f32_t guard;
    if (sd_driveline_guard_init_f32(&guard, &tables) != SD_OK) { return 1u; }
    sd_driveline_out_f32_t out = { .location = 0u };
    uint32_t met = 0;
    budget_class(not_counted);
    for (uint32_t k = 0; k < 6000u; k++) {
        const bool up = (k / 1000u) % 2u == 0u;
        const sd_driveline_tooth_f32_t tooth =
            { .period_ticks = 500u + (k & 1u), .advance = 1u, .gear = 1u, .torque_nm = up ? 40.0f : -20.0f };
        sd_driveline_guard_step_f32(&guard, &tables, &tooth, &out);
        kept = out.twist_rad;
        met |= 1u << out.location;
        budget_class((k < 1500u) ? not_counted : regular);
    }
    return (out.location == 0u) || (met < 8u) ? 1u : 0u;
}

static uint32_t count_guard_q31(uint32_t not_counted, uint32_t regular) {
    static sd_driveline_guard_q31_t guard;
    if (sd_driveline_guard_init_q31(&guard, &tables) != SD_OK) { return 1u; }
    sd_driveline_out_q31_t out = { .location = 0u };
    const sd_q31_t up = SD_CONSTANT_q31(40.0f, SD_DRIVELINE_TORQUE_BITS), down = SD_CONSTANT_q31(-20.0f, SD_DRIVELINE_TORQUE_BITS);
    uint32_t met = 0;
    budget_class(not_counted);
    for (uint32_t k = 0; k < 6000u; k++) {
        const sd_driveline_tooth_q31_t tooth = { .period_ticks = 500u + (k & 1u), .advance = 1u, .gear = 1u,
                                                 .torque_nm = ((k / 1000u) % 2u == 0u) ? up : down };
        sd_driveline_guard_step_q31(&guard, &tables, &tooth, &out);
        kept_q31 = out.twist_rad;
        met |= 1u << out.location;
        budget_class((k < 1500u) ? not_counted : regular);
    }
    return (out.location == 0u) || (met < 8u) ? 1u : 0u;
}

static uint32_t count_bank(uint32_t not_counted, uint32_t step) {
    static sd_driveline_hybrid_t observer;
    static sd_driveline_bank_t bank = { .period_s = 0.01f, .threshold_rpm = 0.02f, .rpm_per_radps = 9.549297f, .middle_rad = -0.025f };
    for (uint32_t q = 0; q < SD_DRIVELINE_LOCATIONS; q++) {
        for (uint32_t i = 0; i < 3u; i++) { bank.residual[q].by_state[i][i] = bank.observer[q].by_state[i][i] = 0.9f; }
        bank.residual[q].by_speed[1][1] = bank.observer[q].by_speed[1][1] = 0.0105f;
    }
    if (sd_driveline_hybrid_init(&observer, &bank, 3u) != SD_OK) { return 1u; }
    sd_driveline_hybrid_out_t out;
    budget_class(not_counted);
    for (uint32_t k = 0; k < 200u; k++) {
        sd_driveline_hybrid_step(&observer, &bank, 0.0f, 0.0f, (float)(k & 7u), &out);
        kept = out.x[0];
        budget_class(step);
    }
    return 0u;
}

uint32_t budget_count_driveline(uint32_t not_counted, uint32_t guard, uint32_t bank) {
    fill_gear();
    return count_guard_f32(not_counted, guard) | count_guard_q31(not_counted, guard) | count_bank(not_counted, bank);
}
