/* SPDX-License-Identifier: MIT */
/* One block at a time, with plausible numbers: those that a replay of the ecu does not reach. After each step the plugin is
 * told which block it was; 0 is what does not count: starts, and steps before a block has settled. */
#include "board.h"
#include "budget_blocks.h"
#include "sd_afr_chain.h"
#include "sd_afr_joint.h"
#include "sd_switched_wheel.h"

/* block_classes of budget.toml */
enum { NOT_COUNTED, FOLSMO, FOSMO, ROO, JUDGES, OSCILLATORS, FOURIER_LAW, FIXED_GAINS, GUARD, BANK, AIRPATH, CRANK };
enum { CYCLE_POSITIONS = 120, CYLINDERS = 4 };
#define STEP_S 6.67e-4f

static uint32_t failed;
static volatile float   kept_f32; /* so that no step is left out */
static volatile int32_t kept_q31;

static void expect(sd_result_t result, const char *block) {
    if (result == SD_OK) { return; }
    board_print(block);
    board_print(": its configuration was refused\n");
    failed = 1u;
}

/* ---- observers of document 000 ------------------------------------------------------------------------------------ */

/* Tables as the host makes them for a four-cylinder on a wheel of 60 positions. FOLSMO corrects both states from the sample,
 * FOSMO by sliding alone, ROO has no speed of its own. */
static void fill_design(sd_wheel_tables_t *t, uint32_t kind) {
    const float rows[SD_WHEEL_KINDS][2][4] = { { { -0.009f, 0.024f, 0.0012f, 0.009f }, { -0.67f, -0.17f, 0.095f, 0.66f } },
                                               { { -1e-4f, 0.024f, 0.0012f, 0.0f }, { -0.013f, -0.17f, 0.095f, 0.0f } },
                                               { { 0.0f, 0.0f, 0.0f, 0.0f }, { 0.0f, -0.32f, 0.087f, -1.2f } } };
    const float gain[4] = { 1e-4f, 0.4f, (kind == SD_WHEEL_ROO) ? 7.0f : 0.0f, 0.026f }; /* rho, capture, l, slope */
    for (uint32_t i = 0; i < 2u; i++) {
        t->f32.design[kind].table.row[i] = sd_row_of_f32(rows[kind][i]);
        t->q31.design[kind].table.row[i] = sd_row_of_q31(rows[kind][i]);
    }
    sd_wheel_design_f32_t *f = &t->f32.design[kind];
    sd_wheel_design_q31_t *q = &t->q31.design[kind];
    f->sliding = sd_gain_of_f32(gain[0]), f->capture = sd_gain_of_f32(gain[1]);
    q->sliding = sd_gain_of_q31(gain[0]), q->capture = sd_gain_of_q31(gain[1]);
    f->table.output_gain = sd_gain_of_f32(gain[2]), f->table.slope = sd_gain_of_f32(gain[3]);
    q->table.output_gain = sd_gain_of_q31(gain[2]), q->table.slope = sd_gain_of_q31(gain[3]);
    f->table.reduced = q->table.reduced = (kind == SD_WHEEL_ROO) ? 1u : 0u;
    t->delay[kind] = 5;
}

static void fill_tables(sd_wheel_tables_t *t) {
    const float common[3] = { 0.15f, 0.03f, 0.03f }, accel = 0.04f, per_tooth = 64.0f / 30.0f; /* pulse, mean, jump */
    t->positions = CYCLE_POSITIONS / 2, t->cylinders = CYLINDERS, t->speed_shift = 6;
    t->accel_exponent = 17, t->energy_exponent = 19, t->work_exponent = 12;
    t->speed_per_tick = 102.3f, t->speed_numerator = 3432592179u;
    for (uint32_t kind = 0; kind < SD_WHEEL_KINDS; kind++) { fill_design(t, kind); }
    t->f32.pulse = sd_gain_of_f32(common[0]), t->f32.mean = sd_gain_of_f32(common[1]), t->f32.jump = sd_gain_of_f32(common[2]);
    t->q31.pulse = sd_gain_of_q31(common[0]), t->q31.mean = sd_gain_of_q31(common[1]), t->q31.jump = sd_gain_of_q31(common[2]);
    for (uint32_t k = 0; k < CYCLE_POSITIONS / 2; k++) { t->inertia_q31[k] = 0x7ff00000; }
    for (uint32_t i = 0; i < CYLINDERS; i++) {
        const uint32_t tdc = CYCLE_POSITIONS / CYLINDERS * i;
        t->f32.accel[i] = sd_gain_of_f32(accel), t->f32.per_tooth[i] = sd_gain_of_f32(per_tooth);
        t->q31.accel[i] = sd_gain_of_q31(accel), t->q31.per_tooth[i] = sd_gain_of_q31(per_tooth);
        for (uint32_t kind = 0; kind < SD_WHEEL_KINDS; kind++) {
            uint16_t *mark = t->mark[kind];
            mark[tdc] = (uint16_t)(mark[tdc] | ((i + 1u) << 8));
            mark[(tdc + 6u) % CYCLE_POSITIONS] |= (uint16_t)SD_WHEEL_BURNED;
            mark[(tdc + 5u) % CYCLE_POSITIONS] |= (uint16_t)(SD_WHEEL_CLOSES | (i + 1u));
            mark[(tdc + 50u) % CYCLE_POSITIONS] |= (uint16_t)((i + 1u) << 4);
        }
    }
}

/* A firing is judged where it is read, which is a class of its own: `judges`. */
static void count_switched(uint32_t block, uint32_t kind) {
    static sd_wheel_tables_t tables;
    static sd_wheel_f32_t f32;
    static sd_wheel_q31_t q31;
    const sd_wheel_config_f32_t in_f32 = { .definition = 0.5f, .work_min = 0.001f, .speed_change = 0.3f,
                                           .start_firings = 16, .hold_firings = 8, .kind = (uint8_t)kind };
    const sd_wheel_config_q31_t in_q31 = { .definition = 1 << 30, .work_min = 1 << 21, .speed_change = 1 << 29,
                                           .start_firings = 16, .hold_firings = 8, .kind = (uint8_t)kind };
    fill_tables(&tables);
    expect(sd_wheel_init_f32(&f32, &in_f32, &tables), "switched f32");
    expect(sd_wheel_init_q31(&q31, &in_q31, &tables), "switched q31");
    budget_class(NOT_COUNTED);
    for (uint32_t k = 0; k < 10u * CYCLE_POSITIONS; k++) {
        const sd_wheel_tooth_t tooth = { .cycle_position = (uint16_t)(k % CYCLE_POSITIONS), .advance = 1,
                                         .period_ticks = 660u + ((k * 7u) & 15u), .trusted = 1 };
        const uint32_t read = sd_wheel_tooth_f32(&f32, &tables, &tooth, 0.1f);
        if (sd_wheel_tooth_q31(&q31, &tables, &tooth, 1 << 28) != read) { board_print("switched: f32 and q31 differ\n"), failed = 1u; }
        budget_class((k < CYCLE_POSITIONS) ? NOT_COUNTED : block);
        if (read == 0u) { continue; }
        sd_wheel_verdict_f32_t said_f32;
        sd_wheel_verdict_q31_t said_q31;
        sd_wheel_judge_f32(&f32, &tables, read - 1u, 0, &said_f32);
        sd_wheel_judge_q31(&q31, &tables, read - 1u, 0, &said_q31);
        kept_f32 = said_f32.residual, kept_q31 = said_q31.residual;
        budget_class((k < 5u * CYCLE_POSITIONS) ? NOT_COUNTED : JUDGES);
    }
    if ((f32.observer.running == 0u) || (q31.observer.running == 0u)) { board_print("switched: it stopped\n"), failed = 1u; }
}

/* ---- AFR ------------------------------------------------------------------------------------------------------------ */

static sd_exhaust_f32_t exhaust_f32;
static sd_exhaust_q31_t exhaust_q31;
static float    psi_f32[SD_EXHAUST_PSI + 1];
static sd_q31_t psi_q31[SD_EXHAUST_PSI + 1];

static void start_exhaust(void) {
    static float    share_f32[SD_EXHAUST_OPEN];
    static sd_q31_t share_q31[SD_EXHAUST_OPEN];
    for (uint32_t i = 0; i < 45u; i++) { share_f32[i] = 1.0f / 46.0f, share_q31[i] = sd_from_float_q31(share_f32[i]); }
    sd_exhaust_config_t config = {
        .cycle_positions = CYCLE_POSITIONS, .cylinders = CYLINDERS, .open_position = 25, .mass_base_kg = 4.2e-3f };
    for (uint32_t i = 0; i < CYLINDERS; i++) { config.firing_position[i] = (uint16_t)(CYCLE_POSITIONS / CYLINDERS * i); }
    for (uint32_t k = 0; k <= SD_EXHAUST_PSI; k++) {
        psi_f32[k] = 0.4f + 0.008f * (float)k;
        psi_q31[k] = sd_from_float_q31(psi_f32[k]);
    }
    const sd_exhaust_point_t point = { .charge_kg = 7e-4f, .rate_hz = 100.0f, .z0_kg = 1.3e-3f, .pipe_kg = 8e-4f, .delay_positions = 8.5f };
    expect(sd_exhaust_init_f32(&exhaust_f32, &config), "exhaust f32");
    expect(sd_exhaust_init_q31(&exhaust_q31, &config), "exhaust q31");
    expect(sd_exhaust_shares_f32(&exhaust_f32, 0, SD_EXHAUST_OPEN, share_f32), "exhaust f32, shares");
    expect(sd_exhaust_shares_q31(&exhaust_q31, 0, SD_EXHAUST_OPEN, share_q31), "exhaust q31, shares");
    expect(sd_exhaust_set_f32(&exhaust_f32, &point, STEP_S), "exhaust f32, point");
    expect(sd_exhaust_set_q31(&exhaust_q31, &point, STEP_S), "exhaust q31, point");
}

/* sin(2 pi k / 120), by the recursion that multiples of an angle follow. */
static const int32_t *sines(void) {
    static int32_t table[CYCLE_POSITIONS];
    double before = 0.0, now = 0.05233595624294383; /* sin(2 pi / 120) */
    table[1] = (int32_t)(now * 2147483647.0);
    for (uint32_t k = 2u; k < CYCLE_POSITIONS; k++) {
        const double next = 2.0 * 0.9986295347545738 * now - before;
        before = now, now = next;
        table[k] = (int32_t)(now * 2147483647.0);
    }
    return table;
}

static void count_chain(uint32_t block) {
    static sd_afr_chain_f32_t f32;
    static sd_afr_chain_q31_t q31;
    const sd_afr_chain_config_t config = {
        .cycle_positions = CYCLE_POSITIONS, .cylinders = CYLINDERS, .harmonics = 2, .settle_steps = 10,
        .tau1_s = 0.03f, .tau2_s = 0.015f, .gain_air = 0.08f, .gain_cylinder = 3.0f,
        .inversion_gain = 0.02f, .inversion_floor = 0.1f };
    const int32_t *sine_q31 = sines();
    const sd_uego_gains_t gains = { 0 };
    expect(sd_afr_chain_init_f32(&f32, &config), "chain f32");
    expect(sd_afr_chain_init_q31(&q31, &config), "chain q31");
    start_exhaust();
    sd_afr_chain_set_f32(&f32, sine_q31, STEP_S, (block == OSCILLATORS) ? &gains : 0, exhaust_f32.charge);
    sd_afr_chain_set_q31(&q31, sine_q31, STEP_S, (block == OSCILLATORS) ? &gains : 0, exhaust_q31.charge);
    budget_class(NOT_COUNTED);
    for (uint32_t k = 0; k < 600u; k++) {
        const float air = 0.5f + 0.01f * (float)((k * 7u) & 15u) / 16.0f;
        sd_exhaust_now_f32_t now_f32;
        sd_exhaust_now_q31_t now_q31;
        sd_exhaust_step_f32(&exhaust_f32, psi_f32, k % CYCLE_POSITIONS, &now_f32);
        sd_exhaust_step_q31(&exhaust_q31, psi_q31, k % CYCLE_POSITIONS, &now_q31);
        sd_afr_chain_step_f32(&f32, sine_q31, &now_f32, k % CYCLE_POSITIONS, air);
        sd_afr_chain_step_q31(&q31, sine_q31, &now_q31, k % CYCLE_POSITIONS, sd_from_float_q31(air));
        budget_class((k < 2u * CYCLE_POSITIONS) ? NOT_COUNTED : block);
    }
}

static void count_fixed_gains(void) {
    static sd_afr_joint_t joint;
    const sd_afr_joint_config_t config = { .cylinders = CYLINDERS, .cycle_positions = 120, .tau1_s = 0.03f, .tau2_s = 0.015f,
                                           .noise_per_rthz = 2e-4f, .drift = 5e-4f, .start_sd = 0.1f, .reject = 1000.0f };
    const float gains[CYLINDERS + 3] = { 0.01f, 0.01f, 0.01f, 0.01f, 0.01f, 0.01f, 0.01f };
    expect(sd_afr_joint_init(&joint, &config), "joint filter");
    start_exhaust();
    sd_afr_joint_set(&joint, STEP_S, 5e-4f, 0.01f);
    budget_class(NOT_COUNTED);
    for (uint32_t k = 0; k < 600u; k++) {
        sd_exhaust_now_f32_t now;
        sd_exhaust_step_f32(&exhaust_f32, psi_f32, k % CYCLE_POSITIONS, &now);
        sd_afr_inflow_t in;
        sd_afr_inflow_of(&now, &in);
        sd_afr_joint_step(&joint, &in, 0.5f + 0.001f * (float)(k & 7u), gains);
        budget_class((k < 2u * CYCLE_POSITIONS) ? NOT_COUNTED : FIXED_GAINS);
    }
}

int main(void) {
    count_switched(FOLSMO, SD_WHEEL_FOLSMO);
    count_switched(FOSMO, SD_WHEEL_FOSMO);
    count_switched(ROO, SD_WHEEL_ROO);
    count_chain(OSCILLATORS);
    count_chain(FOURIER_LAW);
    count_fixed_gains();
    failed |= budget_count_driveline(NOT_COUNTED, GUARD, BANK);
    failed |= budget_count_airpath(NOT_COUNTED, AIRPATH);
    budget_count_crank(CRANK);
    return (int)failed;
}
