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
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers; the table is
/// read only.
#ifndef SD_NUIO_H
#define SD_NUIO_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_NUIO_STATES  4
#define SD_NUIO_OUTPUTS 2

/// Made on the host (tools/airpath); every number within +-1e6. Units are those of the states over those of the outputs.
typedef struct sd_nuio_table {
    float m[SD_NUIO_STATES][SD_NUIO_STATES];     ///< M = I + E C; M times the direction that is not seen is 0.
    float e[SD_NUIO_STATES][SD_NUIO_OUTPUTS];    ///< E.
    float k[SD_NUIO_STATES][SD_NUIO_OUTPUTS];    ///< K at share 0, 1/s.
    float more[SD_NUIO_STATES][SD_NUIO_OUTPUTS]; ///< K at share 1 minus K at share 0.
    float gamma[SD_NUIO_OUTPUTS];                ///< Makes one residual of the two innovations.
} sd_nuio_table_t;

typedef struct sd_nuio {
    float z[SD_NUIO_STATES];
} sd_nuio_t;

typedef struct sd_nuio_estimate {
    float x[SD_NUIO_STATES];           ///< xhat.
    float innovation[SD_NUIO_OUTPUTS]; ///< y - C xhat.
    float residual;
} sd_nuio_estimate_t;

/// Begins with the estimate x, whose first and last state are the outputs measured now.
void sd_nuio_begin(sd_nuio_t *self, const sd_nuio_table_t *table, const float *x);
/// The estimate with the outputs measured now; the state stays.
void sd_nuio_look(const sd_nuio_t *self, const sd_nuio_table_t *table, const float *y, sd_nuio_estimate_t *out);
/// Goes on by period_s. rate: of the model at out->x, per second; share: of the schedule, [0, 1].
void sd_nuio_step(sd_nuio_t *self, const sd_nuio_table_t *table, const sd_nuio_estimate_t *at, const float *rate, float share,
    float period_s);

#ifdef __cplusplus
}
#endif
#endif
