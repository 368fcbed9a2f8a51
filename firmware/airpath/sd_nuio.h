/* SPDX-License-Identifier: MIT */
/// sd_nuio.h - one nonlinear unknown-input observer: an estimate that one unknown input cannot disturb, after B. Boulkroune and others,
/// "Actuator fault diagnosis with application to a diesel engine testbed", 2015 (document 001), equation (7).
///
///     z' = N z + L y + G g + M phi(xhat),   xhat = z - E y,   residual = gamma (y - C xhat)
/// With N = M A - K C and L = K (I + C E) - M A E this is
///     z' = M (A xhat + B g + phi(xhat)) + K (y - C xhat),
/// so the block takes the model's rate at its own estimate and knows nothing of the model. K is scheduled by a share between two ends. One
/// step is Euler's. C picks the first and the last state. The caller estimates, computes the model's rate there, and steps.
///
/// Two variants from one body: _f32 in units, _q31 per unit of the bases that the model has (sd_airpath_flows.h).
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers; the table is
/// read only.
#ifndef SD_NUIO_H
#define SD_NUIO_H
#include "sd_bases.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_NUIO_STATES  4 ///< Of sd_airpath_state_t.
#define SD_NUIO_OUTPUTS 2 ///< The two measured pressures.

/// The table is made on the host (tools/airpath); in f32 every number within +-1e6, units are those of the states over those of the
/// outputs. In q31 they are coefficients of sd_bases.h.
#define SD_NUIO_DECLARE(N, T)                                                                                          \
    typedef struct sd_nuio_table_##N {                                                                                 \
        T m[SD_NUIO_STATES][SD_NUIO_STATES];     /* M = I + E C; M times the direction that is not seen is 0. */       \
        T e[SD_NUIO_STATES][SD_NUIO_OUTPUTS];    /* E. */                                                              \
        T k[SD_NUIO_STATES][SD_NUIO_OUTPUTS];    /* K at share 0, 1/s. */                                              \
        T more[SD_NUIO_STATES][SD_NUIO_OUTPUTS]; /* K at share 1 minus K at share 0. */                                \
        T gamma[SD_NUIO_OUTPUTS];                /* Makes one residual of the two innovations. */                      \
    } sd_nuio_table_##N##_t;                                                                                           \
    typedef struct sd_nuio_##N {                                                                                       \
        T z[SD_NUIO_STATES];                                                                                           \
    } sd_nuio_##N##_t;                                                                                                 \
    typedef struct sd_nuio_estimate_##N {                                                                              \
        T x[SD_NUIO_STATES];           /* xhat. */                                                                     \
        T innovation[SD_NUIO_OUTPUTS]; /* y - C xhat. */                                                               \
        T residual;                                                                                                    \
    } sd_nuio_estimate_##N##_t;                                                                                        \
    /* Whether every number is within the range said above. */                                                         \
    bool sd_nuio_table_ok_##N(const sd_nuio_table_##N##_t *table);                                                     \
    /* Begins with the estimate x, whose first and last state are the outputs measured now. */                         \
    void sd_nuio_begin_##N(sd_nuio_##N##_t *self, const sd_nuio_table_##N##_t *table, const T *x);                     \
    /* The estimate with the outputs measured now; the state stays. */                                                 \
    void sd_nuio_look_##N(const sd_nuio_##N##_t *self, const sd_nuio_table_##N##_t *table, const T *y,                 \
                          sd_nuio_estimate_##N##_t *out);                                                              \
    /* Goes on by period. rate: of the model at out->x, per second; share: of the schedule, [0, 1]. */                 \
    void sd_nuio_step_##N(sd_nuio_##N##_t *self, const sd_nuio_table_##N##_t *table, const sd_nuio_estimate_##N##_t *at, \
                          const T *rate, T share, T period);

SD_NUIO_DECLARE(f32, float)
SD_NUIO_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif
#endif
