/* SPDX-License-Identifier: MIT */
/// sd_airpath_offsets.h - the mean that residuals have without a fault, learned while the engine runs. A model whose parameters are 2 %
/// off leaves residuals a mean as large as a fault's; it is in proportion to the flow of air, so it is learned as a share of it.
///
/// What is learned at the start may be a fault that was there already: nothing in the residuals can tell. So the block says how large what
/// it learned is, in faults of interest, and sets `suspect` from half of one on.
///
/// Two variants from one body; in q31 residuals are per unit of 2^10 kPa, flows of 2^16 g/s, what is learned of 16 kPa s/g.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers.
#ifndef SD_AIRPATH_OFFSETS_H
#define SD_AIRPATH_OFFSETS_H
#include "sd_bases.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_RESIDUALS 2 ///< One of each observer.

/// State and functions of the offsets in one number type: N is f32 or q31, T its type.
#define SD_AIRPATH_OFFSETS_DECLARE(N, T)                                                                               \
    typedef struct sd_airpath_offsets_##N {                                                                            \
        sd_acc_##N##_t sum[SD_AIRPATH_RESIDUALS];  /* Of the window under way. */                                      \
        sd_acc_##N##_t flow_sum;                   /* Of the same steps, g/s. */                                       \
        T        per_flow[SD_AIRPATH_RESIDUALS];   /* Learned: mean residual over mean flow; 0 before. */              \
        uint32_t steps;                            /* Of the window under way. */                                      \
        uint8_t  learned;                          /* 1: a window is complete. */                                      \
        uint8_t  suspect;                          /* 1: what was learned is as large as half of a fault of interest. */ \
        uint8_t  reserved[2];                                                                                          \
    } sd_airpath_offsets_##N##_t;                                                                                      \
    /* Nothing learned. */                                                                                             \
    void sd_airpath_offsets_start_##N(sd_airpath_offsets_##N##_t *self);                                               \
    /* The window under way is dropped; what was learned stays. */                                                     \
    void sd_airpath_offsets_drop_##N(sd_airpath_offsets_##N##_t *self);                                                \
    /* A step of a healthy window of window_steps, (0, 1e6]. flow > 0. True when it has completed the window. */       \
    bool sd_airpath_offsets_step_##N(sd_airpath_offsets_##N##_t *self, uint32_t window_steps, const T *residual, T flow); \
    /* What was learned of a residual, at this flow. */                                                                \
    T sd_airpath_offset_##N(const sd_airpath_offsets_##N##_t *self, uint32_t residual, T flow);

SD_AIRPATH_OFFSETS_DECLARE(f32, float)
SD_AIRPATH_OFFSETS_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif
#endif
