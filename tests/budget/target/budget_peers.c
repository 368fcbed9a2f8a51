/* SPDX-License-Identifier: MIT */
/* One whole step of the torque observer with five harmonics, in several ways that give the same torque: sd_fourier in both number
 * types, C that CasADi generated from the same equations, and a dense matrix of the position times the state, in the shapes that
 * two libraries give that product (docs/results/costs.md). And that product for the sizes of other blocks. */
#include <stddef.h>

#include "board.h"
#include "sd_fourier.h"

enum { NOT_COUNTED, OURS, CASADI, COLUMNS, ROWS, SIZES }; /* peer_classes of budget.toml; SIZES and the next two: n of size[] */
enum { POSITIONS = 60, CYCLE = 2 * POSITIONS, HARMONICS = 5, STATES = 2 * HARMONICS + 2, STEPS = 40 * CYCLE };

int casadi_torque(const float **arg, float **res, int *iw, float *w, int mem); /* peers/casadi_torque.c */

static sd_fourier_tables_t tables;
static sd_fourier_f32_t f32;
static sd_fourier_q31_t q31;
static float gain[4];                        /* as CasADi's p: torque to energy; of energy, mean and first harmonic */
static float transition[CYCLE][STATES * STATES]; /* of a position, a row behind the other */
static float by_column[CYCLE][STATES * STATES];  /* the same, a column behind the other */
static float input[CYCLE][STATES], output[CYCLE][STATES], output_input[CYCLE];
static volatile float kept;
static uint32_t failed;

static float sine(uint32_t k) { return sd_from_q31_f32(tables.sine_q31[k % CYCLE]); }
static float inertia(uint32_t k) { return sd_from_q31_f32(tables.inertia_q31[k % POSITIONS]); }

/* ---- set up, not counted ------------------------------------------------------------------------------------------ */

static void fill_tables(void) {
    double before = 0.0, now = 0.05233595624294383; /* sin(2 pi / 120), and the recursion that multiples of an angle follow */
    tables.inertia_base_kgm2 = 0.25f;
    for (uint32_t k = 0; k < POSITIONS; k++) { tables.inertia_q31[k] = 0x7f000000 - (int32_t)((k % 15u) << 20); }
    tables.sine_q31[1] = (int32_t)(now * 2147483647.0);
    for (uint32_t k = 2u; k < CYCLE; k++) {
        const double next = 2.0 * 0.9986295347545738 * now - before;
        before = now, now = next;
        tables.sine_q31[k] = (int32_t)(now * 2147483647.0);
    }
}

/* The step as plain loops, for the energy measured: from it the matrices come. Returns the torque. */
static float plain_step(float *x, uint32_t k, float measured) {
    const float error = x[0] - measured, c = sine(k + POSITIONS / 2u), s = sine(k);
    float cos_i = c, sin_i = s, torque;
    x[1] -= gain[2] * error;
    torque = x[1];
    for (uint32_t i = 1; i <= HARMONICS; i++) {
        const float pull = (float)i * gain[3] * error, turned = cos_i * c - sin_i * s;
        x[2u * i] -= pull * cos_i, x[2u * i + 1u] -= pull * sin_i;
        torque += x[2u * i] * cos_i + x[2u * i + 1u] * sin_i;
        sin_i = cos_i * s + sin_i * c, cos_i = turned;
    }
    x[0] += gain[0] * torque - gain[1] * error;
    return torque;
}

static void fill_matrices(void) {
    for (uint32_t k = 0; k < CYCLE; k++) {
        for (uint32_t j = 0; j < STATES; j++) {
            float x[STATES] = { 0.0f };
            x[j] = 1.0f;
            output[k][j] = plain_step(x, k, 0.0f);
            for (uint32_t i = 0; i < STATES; i++) { transition[k][i * STATES + j] = by_column[k][j * STATES + i] = x[i]; }
        }
        float x[STATES] = { 0.0f };
        output_input[k] = plain_step(x, k, 1.0f);
        for (uint32_t i = 0; i < STATES; i++) { input[k][i] = x[i]; }
    }
}

/* ---- dense products ------------------------------------------------------------------------------------------------ */

/* to = a x by columns, as Eigen's product of a matrix of a size known at run time: four columns at a time add to the whole result. */
static inline void product_by_columns(const float *restrict a, const float *restrict x, float *restrict to, uint32_t n) {
    uint32_t j = 0;
    for (uint32_t i = 0; i < n; i++) { to[i] = 0.0f; }
    for (; j + 4u <= n; j += 4u, a += 4u * n) {
        const float *a1 = a + n, *a2 = a1 + n, *a3 = a2 + n;
        for (uint32_t i = 0; i < n; i++) { to[i] += (a[i] * x[j] + a1[i] * x[j + 1u]) + (a2[i] * x[j + 2u] + a3[i] * x[j + 3u]); }
    }
    for (; j < n; j++, a += n) {
        for (uint32_t i = 0; i < n; i++) { to[i] += a[i] * x[j]; }
    }
}

/* to = a x by rows, in the shape that a signal-processing library has for small cores: four rows at a time share each x, and what
 * is left goes row by row in fours. */
static inline void product_by_rows(const float *restrict a, const float *restrict x, float *restrict to, uint32_t n) {
    uint32_t row = 0;
    for (; row + 4u <= n; row += 4u) {
        const float *a0 = a + row * n, *a1 = a0 + n, *a2 = a1 + n, *a3 = a2 + n, *in = x;
        float s0 = 0.0f, s1 = 0.0f, s2 = 0.0f, s3 = 0.0f;
        for (uint32_t left = n; left > 0u; left--) {
            const float value = *in++;
            s0 += *a0++ * value, s1 += *a1++ * value, s2 += *a2++ * value, s3 += *a3++ * value;
        }
        to[row] = s0, to[row + 1u] = s1, to[row + 2u] = s2, to[row + 3u] = s3;
    }
    for (; row < n; row++) {
        const float *in = x, *of = a + row * n;
        float sum = 0.0f;
        uint32_t left = n;
        for (; left >= 4u; left -= 4u, in += 4, of += 4) { sum += of[0] * in[0] + of[1] * in[1] + of[2] * in[2] + of[3] * in[3]; }
        for (; left > 0u; left--) { sum += *of++ * *in++; }
        to[row] = sum;
    }
}

/* A whole step: energy from the period, x <- A x + b energy, torque = c x + d energy. Sizes come at run time, as to a library. */
#define DENSE_STEP(NAME, PRODUCT, MATRIX)                                                                                                  \
    __attribute__((noinline)) float NAME(float *restrict x, uint32_t k, uint32_t n, uint32_t base_ticks, uint32_t period_ticks);           \
    __attribute__((noinline)) float NAME(float *restrict x, uint32_t k, uint32_t n, uint32_t base_ticks, uint32_t period_ticks) {          \
        float next[STATES];                                                                                                                \
        const float speed = (float)base_ticks / (float)period_ticks, measured = inertia(k) * speed * speed;                                \
        float torque = output_input[k] * measured;                                                                                         \
        PRODUCT(MATRIX[k], x, next, n);                                                                                                    \
        for (uint32_t i = 0; i < n; i++) { torque += output[k][i] * x[i]; }                                                                \
        for (uint32_t i = 0; i < n; i++) { x[i] = next[i] + input[k][i] * measured; }                                                      \
        return torque;                                                                                                                     \
    }
DENSE_STEP(peer_columns, product_by_columns, by_column)
DENSE_STEP(peer_rows, product_by_rows, transition)
static float (*volatile columns)(float *restrict, uint32_t, uint32_t, uint32_t, uint32_t) = peer_columns; /* not specialised for one n */
static float (*volatile rows)(float *restrict, uint32_t, uint32_t, uint32_t, uint32_t) = peer_rows;

/* CasADi's calling convention wants the inputs in arrays, so gathering them is part of the step. */
__attribute__((noinline)) float peer_casadi(float *x, uint32_t k, uint32_t base_ticks, uint32_t period_ticks);
__attribute__((noinline)) float peer_casadi(float *x, uint32_t k, uint32_t base_ticks, uint32_t period_ticks) {
    const float measured[4] = { (float)period_ticks / (float)base_ticks, inertia(k), sine(k + POSITIONS / 2u), sine(k) };
    float torque;
    const float *arg[3] = { x, measured, gain };
    float *res[2] = { x, &torque };
    (void)casadi_torque(arg, res, NULL, NULL, 0);
    return torque;
}

/* ---- the run ------------------------------------------------------------------------------------------------------- */

static float apart(float a, float b) { return (a > b) ? a - b : b - a; }

static void compare_steps(void) {
    static float casadi[STATES], column[STATES], row[STATES];
    float largest = 0.0f;
    casadi[0] = column[0] = row[0] = 0.04f;
    for (uint32_t k = 0; k < STEPS; k++) {
        const uint32_t at = k % CYCLE, swing = at % 30u, period = 66000u + 40u * ((swing < 15u) ? swing : 30u - swing);
        const float ours = sd_fourier_step_f32(&f32, &tables, at, 1u, period, 1u);
        const float fixed = sd_fourier_step_q31(&q31, &tables, at, 1u, period, 1u);
        budget_class((k < CYCLE) ? NOT_COUNTED : OURS);
        const float by_casadi = peer_casadi(casadi, at, f32.period_base_ticks, period);
        budget_class((k < CYCLE) ? NOT_COUNTED : CASADI);
        const float dense = columns(column, at, STATES, f32.period_base_ticks, period);
        budget_class((k < CYCLE) ? NOT_COUNTED : COLUMNS);
        const float dense_rows = rows(row, at, STATES, f32.period_base_ticks, period);
        budget_class((k < CYCLE) ? NOT_COUNTED : ROWS);
        if (k < STEPS - CYCLE) { continue; } /* until where each started is forgotten */
        const float base = 1.0f / f32.torque_base_nm;
        largest = (apart(ours * base, 0.0f) > largest) ? apart(ours * base, 0.0f) : largest;
        if ((apart(ours, fixed) * base > 1e-5f) || (apart(ours * base, by_casadi) > 1e-5f) || (apart(ours * base, dense) > 1e-5f) ||
            (apart(ours * base, dense_rows) > 1e-5f)) { failed |= 1u; }
    }
    if (largest < 1e-3f) { failed |= 2u; } /* then the comparison is about nothing */
}

int main(void) {
    static const uint32_t size[3] = { 2, 5, 7 }; /* a switched observer, the observer of four cylinders, the sensor inverted */
    static float x[STATES];
    const sd_fourier_config_t config = { .positions = POSITIONS, .harmonics = HARMONICS, .gain_energy = 1.0f, .gain_mean = 0.3f,
                                         .gain_reference = 0.05f, .reject_energy = 1.0f, .settle_steps = 100, .tick_hz = 1e8f,
                                         .speed_base_radps = 800.0f, .torque_base_nm = 1500.0f };
    fill_tables();
    if ((sd_fourier_init_f32(&f32, &config, &tables) != SD_OK) || (sd_fourier_init_q31(&q31, &config, &tables) != SD_OK)) {
        board_print("peers: the observer was refused\n");
        return 1;
    }
    gain[0] = f32.to_energy.factor, gain[1] = f32.gain_energy.factor, gain[2] = f32.gain_mean.factor, gain[3] = f32.gain_reference.factor;
    fill_matrices();
    budget_class(NOT_COUNTED);
    compare_steps();
    for (uint32_t i = 0; i < 3u; i++) {
        kept = columns(x, 3u, size[i], 13089u, 66000u);
        kept = rows(x, 3u, size[i], 13089u, 66000u);
        budget_class(SIZES + i);
    }
    if (failed != 0u) { board_print("peers: the ways do not give the same torque, or none\n"); }
    return (int)failed;
}
