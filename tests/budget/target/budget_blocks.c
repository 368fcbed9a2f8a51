/* SPDX-License-Identifier: MIT */
/* One block at a time, with plausible numbers: those that a replay of the ecu does not reach. After each step the plugin is
 * told which block it was; 0 is what does not count: starts, and steps before a block has settled. */
#include "board.h"
#include "budget_blocks.h"
#include "sd_afr_chain.h"
#include "sd_afr_joint.h"
#include "sd_input_observer.h"
#include "sd_switched.h"

enum { NOT_COUNTED, FOLSMO, FOSMO, ROO, INPUT, OSCILLATORS, FOURIER_LAW, FIXED_GAINS, GUARD, BANK, CRANK }; /* block_classes of budget.toml */
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

/* FOLSMO corrects both states from the sample, FOSMO by sliding alone, ROO has no speed of its own. */
static void plant_steps(sd_plant_step_t steps[4], uint32_t block) {
    for (uint32_t i = 0; i < 4u; i++) {
        steps[i] = (sd_plant_step_t){ .period_ticks = 5000u + 3000u * i, .increment = { { -1e-5f, 1e-4f }, { -0.09f, -2e-3f } },
                                      .from_input = { 5e-9f, 1e-4f }, .from_output = { 1e-5f, 0.08f } };
        if (block == FOSMO) { steps[i].from_output[0] = steps[i].from_output[1] = 0.0f; }
        if (block != ROO) { continue; }
        steps[i].increment[0][0] = steps[i].increment[0][1] = steps[i].increment[1][0] = steps[i].from_output[0] = 0.0f;
    }
}

static void count_switched(uint32_t block) {
    static sd_switched_f32_t f32;
    static sd_switched_q31_t q31;
    sd_plant_step_t steps[4];
    plant_steps(steps, block);
    const sd_switched_config_t config = {
        .steps = steps, .step_count = 4, .speed_base_mps = 20.0f, .accel_base_mps2 = 1000.0f, .jerk_base_mps3 = 1e5f, .settle_steps = 100,
        .sliding_gain_mps3 = (block == ROO) ? 0.0f : 40.0f, .output_gain_per_s = (block == ROO) ? 13.0f : 0.0f };
    expect(sd_switched_init_f32(&f32, &config), "switched f32");
    expect(sd_switched_init_q31(&q31, &config), "switched q31");
    sd_switched_start_f32(&f32, 0.1f, 0.1f, 0.0f);
    sd_switched_start_q31(&q31, 1 << 27, 1 << 27, 0);
    budget_class(NOT_COUNTED);
    for (uint32_t k = 0; k < 200u; k++) {
        const uint32_t period = 6000u + 100u * (k & 31u);
        kept_f32 = sd_switched_step_f32(&f32, period, 0.1f + 0.001f * (float)(k & 7u), 0.01f);
        kept_q31 = sd_switched_step_q31(&q31, period, (1 << 27) + (int32_t)(k & 7u) * 1000, 1 << 24);
        budget_class((k < 10u) ? NOT_COUNTED : block);
    }
    if ((f32.running == 0u) || (q31.running == 0u)) { board_print("switched: it stopped\n"), failed = 1u; }
}

static void count_input(void) {
    static sd_input_observer_t observer;
    sd_plant_step_t steps[4];
    plant_steps(steps, FOLSMO);
    const sd_input_config_t config = {
        .step = steps, .cylinders = CYLINDERS, .noise_mps = 1e-3f, .start_speed_mps = 0.3f, .start_accel_mps2 = 50.0f,
        .start_strength = 0.5f, .walk_strength = 1e-5f, .alarm_sd = 4.0f, .settle_steps = 100 };
    const float strength[CYLINDERS] = { 1.0f, 1.0f, 1.0f, 1.0f }, input[CYLINDERS] = { 1000.0f, 10.0f, 0.0f, 0.0f };
    expect(sd_input_init(&observer, &config), "input observer");
    sd_input_start(&observer, 0.0f, 0.0f, strength);
    budget_class(NOT_COUNTED);
    for (uint32_t k = 0; k < 200u; k++) {
        kept_f32 = sd_input_step(&observer, 1e-3f * (float)(k & 7u), input, (uint8_t)((k / 30u) & 3u));
        budget_class((k < 10u) ? NOT_COUNTED : INPUT);
    }
}

/* ---- AFR ------------------------------------------------------------------------------------------------------------ */

static sd_exhaust_f32_t exhaust_f32;
static sd_exhaust_q31_t exhaust_q31;
static float    psi_f32[SD_EXHAUST_PSI + 1];
static sd_q31_t psi_q31[SD_EXHAUST_PSI + 1];

static void start_exhaust(void) {
    static float share[SD_EXHAUST_OPEN];
    for (uint32_t i = 0; i < 45u; i++) { share[i] = 1.0f / 46.0f; }
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
    expect(sd_exhaust_shares_f32(&exhaust_f32, 0, SD_EXHAUST_OPEN, share), "exhaust f32, shares");
    expect(sd_exhaust_shares_q31(&exhaust_q31, 0, SD_EXHAUST_OPEN, share), "exhaust q31, shares");
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
    sd_afr_chain_set_f32(&f32, sine_q31, STEP_S, (block == OSCILLATORS) ? &gains : 0, 1.0f / 6.0f);
    sd_afr_chain_set_q31(&q31, sine_q31, STEP_S, (block == OSCILLATORS) ? &gains : 0, 1.0f / 6.0f);
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
    const sd_afr_joint_config_t config = { .cylinders = CYLINDERS, .tau1_s = 0.03f, .tau2_s = 0.015f, .noise_per_rthz = 2e-4f,
                                           .drift = 5e-4f, .start_sd = 0.1f, .reject = 1000.0f };
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
    count_switched(FOLSMO);
    count_switched(FOSMO);
    count_switched(ROO);
    count_input();
    count_chain(OSCILLATORS);
    count_chain(FOURIER_LAW);
    count_fixed_gains();
    failed |= budget_count_driveline(NOT_COUNTED, GUARD, BANK);
    budget_count_crank(CRANK);
    return (int)failed;
}
