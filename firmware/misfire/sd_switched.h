/* SPDX-License-Identifier: MIT */
/// sd_switched.h - the switched observers of document 000: ROO, FOSMO and FOLSMO, for the crank's acceleration.
///
/// Plant: v1' = v2, v2' = -k2 v2 - k1 v1 + C Q. All cylinders share its numbers; which of them is active shows in the input C Q
/// alone, so switching is the caller's choice of input. With e1 = y - v1^ (the document's sign restored, docs/theory/observers.md):
///   FOLSMO  v1^' = v2^,  v2^' = -k2 v2^ - k1 v1^ + C Q + L e1 + rho sgn(e1)          equations (5), (6)
///   FOSMO   the same with L = 0
///   ROO     z' = -(k2 + l) z - (k1 + l (k2 + l)) y + C Q,  v2^ = z + l y
/// All three are one step, x+ = x + D x + g (u + rho sgn(e1)) + h ym, acceleration = x2 + l y, with different numbers:
/// L stands in D and h, ROO has x1 = 0. u is the mean input over the step and ym the mean of its two samples, so the
/// step is exact but for the curvature of y within it; sgn(e1) is held over a step. docs/theory/observers.md says what each is
/// worth: none of them finds a misfire that its input does not know of.
///
/// A table is made for one length of the step: an interval of time, or of crank angle where k1, k2 and the input are those of the
/// angle domain, which do not change with speed (sd_switched_wheel.h). A step whose sample is missing is coasted.
///
/// Two variants from one body, _f32 and _q31; everything is per unit of bases that the maker of the table chose, and q31 uses
/// no floating point anywhere. Real-time contract: no heap, no globals, no libm, no loop. Call order: start; step or coast for
/// every sample.
#ifndef SD_SWITCHED_H
#define SD_SWITCHED_H
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// One variant: T is its number type. Plain data, caller-owned; the table is read only and may stand in flash.
#define SD_SWITCHED_DECLARE(N, T)                                                                                      \
    typedef struct sd_switched_table_##N {                                                                             \
        sd_row_##N##_t  row[2];      /* D, g and h of each state: columns x1, x2, u, ym */                             \
        sd_gain_##N##_t output_gain; /* l of ROO; 0 for the others */                                                  \
        sd_gain_##N##_t slope;       /* change of y over a step at acceleration 1 */                                   \
        uint32_t        reduced;     /* 1: ROO, which has no v1^ of its own */                                         \
    } sd_switched_table_##N##_t;                                                                                       \
    typedef struct sd_switched_##N {                                                                                   \
        T state[2];            /* v1^ (ROO: 0), v2^ less l y */                                                        \
        T output;              /* last good sample */                                                                  \
        T accel;               /* v2^ */                                                                               \
        T sliding;             /* rho, [0, 1); written by the caller */                                                \
        uint16_t rejected;     /* samples left out, saturating */                                                      \
        uint16_t rejected_in_row;                                                                                      \
        uint16_t running;                                                                                              \
    } sd_switched_##N##_t;                                                                                             \
    /* Begins at sample y with v1^ and v2^ as given. One that is out of (-1, 1) is counted, and nothing runs. */       \
    void sd_switched_start_##N(sd_switched_##N##_t *self, const sd_switched_table_##N##_t *table, T y, T speed, T accel); \
    /* One step to sample y; u: mean input over it. Not running: begins at y with v2^ = 0. A sample or input out of */ \
    /* (-1, 1), NaN included, is replaced by the sample before it or by 0, and counted; after 12 in a row it stops */  \
    /* running. Returns v2^, 0 while not running; never NaN. */                                                        \
    T sd_switched_step_##N(sd_switched_##N##_t *self, const sd_switched_table_##N##_t *table, T y, T u);               \
    /* One step without a sample: y is taken to be where the estimate leads. Returns v2^, 0 while not running. */      \
    T sd_switched_coast_##N(sd_switched_##N##_t *self, const sd_switched_table_##N##_t *table, T u);                   \
    /* e1: the last sample less v1^; 0 in ROO. */                                                                      \
    T sd_switched_error_##N(const sd_switched_##N##_t *self, const sd_switched_table_##N##_t *table);

SD_SWITCHED_DECLARE(f32, float)
SD_SWITCHED_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
