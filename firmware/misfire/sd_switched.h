/* SPDX-License-Identifier: MIT */
/// sd_switched.h - the switched observers of document 000: ROO, FOSMO and FOLSMO, for the crank's acceleration.
///
/// Plant: sd_plant_step.h. All cylinders share its matrices; which of them is active shows in the input C Q alone, so
/// switching is the caller's choice of input. With e1 = y - v1^ (the document's sign restored, docs/misfire.md):
///   FOLSMO  v1^' = v2^,  v2^' = -k2 v2^ - k1 v1^ + C Q + L e1 + rho sgn(e1)          equations (5), (6)
///   FOSMO   the same with L = 0
///   ROO     z' = -(k2 + l) z - (k1 + l (k2 + l)) y + C Q,  v2^ = z + l y
/// All three are one step, x+ = x + D x + g (u + rho sgn(e1)) + h ym, acceleration = x2 + l y, with different numbers:
/// L stands in D and h, ROO has x1 = 0. u is the mean input over the step and ym the mean of its two samples, so the
/// step is exact but for the curvature of y within it; sgn(e1) is held over a step. docs/misfire.md says what each is
/// worth: none of them finds a misfire that its input does not know of.
///
/// Time domain: one step length, that of the sampling. Angle domain: a step a tooth, with a table of step lengths in
/// ascending order, between which increments are interpolated; a missing tooth is a longer step.
///
/// Two variants from one body, _f32 and _q31; y and u are per unit of the bases below. Real-time contract: no heap, no
/// globals, no libm, no loop but the search of the table. Call order: init; start; step for every sample; read.
#ifndef SD_SWITCHED_H
#define SD_SWITCHED_H
#include "sd_num.h"
#include "sd_plant_step.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// SI units; read by init only, need not outlive it.
typedef struct sd_switched_config {
    const sd_plant_step_t *steps; ///< [step_count], period_ticks ascending.
    uint8_t  step_count;          ///< 1 to SD_PLANT_STEPS_MAX; with 1 the period is not looked at.
    float    output_gain_per_s;   ///< l of ROO, [0, 1e5]; 0 for the others.
    float    sliding_gain_mps3;   ///< rho, [0, jerk_base_mps3).
    float    speed_base_mps;      ///< Highest |v1|, (0, 1e4]; per-unit base.
    float    accel_base_mps2;     ///< Highest |v2| and, in ROO, |z| and |l y|; (0, 1e6].
    float    jerk_base_mps3;      ///< Highest |C Q|, (0, 1e8].
    uint16_t settle_steps;        ///< Steps until the estimate counts as converged.
} sd_switched_config_t;

typedef struct sd_switched_estimate {
    float speed_mps;   ///< v1^; the last sample in ROO.
    float accel_mps2;  ///< v2^.
    sd_status_t status; ///< innovation: e1 after the step, m/s (0 in ROO). rejected: samples left out.
} sd_switched_estimate_t;

/// One variant: T is its number type. State first, then what init derived. Plain data, caller-owned.
#define SD_SWITCHED_DECLARE(N, T)                                                                                      \
    typedef struct sd_switched_row_##N {                                                                               \
        uint32_t period_ticks;                                                                                         \
        sd_gain_##N##_t increment[2][2], from_input[2], from_output[2]; /* per-unit */                                 \
    } sd_switched_row_##N##_t;                                                                                         \
    typedef struct sd_switched_##N {                                                                                   \
        T state[2];            /* per unit of speed_base, accel_base */                                                \
        T output;              /* last good sample */                                                                  \
        T accel;               /* per unit of accel_base */                                                            \
        uint16_t steps, rejected, rejected_in_row;                                                                     \
        uint8_t  running;                                                                                              \
        uint8_t  row_count;                                                                                            \
        uint16_t settle_steps;                                                                                         \
        uint8_t  reduced;      /* ROO: no v1^ of its own */                                                            \
        T sliding;             /* rho, per unit of jerk_base */                                                        \
        sd_gain_##N##_t output_gain;                                                                                   \
        float speed_base_mps, accel_base_mps2;                                                                         \
        sd_switched_row_##N##_t row[SD_PLANT_STEPS_MAX];                                                               \
    } sd_switched_##N##_t;                                                                                             \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. Starts not running. */                                        \
    sd_result_t sd_switched_init_##N(sd_switched_##N##_t *self, const sd_switched_config_t *config);                   \
    /* Begins at sample y with v1^ and v2^ as given, all per-unit. */                                                  \
    void sd_switched_start_##N(sd_switched_##N##_t *self, T y, T speed, T accel);                                      \
    /* One step, period_ticks long, to sample y; u: mean of C Q over it. Not running: begins at y with v2^ = 0. A */   \
    /* sample or input out of (-1, 1), NaN included, is replaced by the sample before it or by 0, and counted; after */\
    /* 12 in a row, and for a period outside the table, it stops running. Returns v2^, per-unit, 0 while not */        \
    /* running; never NaN. */                                                                                          \
    T sd_switched_step_##N(sd_switched_##N##_t *self, uint32_t period_ticks, T y, T u);                                \
    void sd_switched_read_##N(const sd_switched_##N##_t *self, sd_switched_estimate_t *estimate);

SD_SWITCHED_DECLARE(f32, float)
SD_SWITCHED_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
