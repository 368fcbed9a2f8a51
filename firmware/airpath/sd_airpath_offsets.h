/* SPDX-License-Identifier: MIT */
/// sd_airpath_offsets.h - the mean that residuals have without a fault, learned while the engine runs. A model whose parameters are 2 %
/// off leaves residuals a mean as large as a fault's; it is in proportion to the flow of air, so it is learned as a share of it.
///
/// What is learned at the start may be a fault that was there already: nothing in the residuals can tell. So the block says how large what
/// it learned is, in faults of interest, and sets `suspect` from half of one on.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers.
#ifndef SD_AIRPATH_OFFSETS_H
#define SD_AIRPATH_OFFSETS_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_RESIDUALS 2

typedef struct sd_airpath_offsets {
    float    per_flow[SD_AIRPATH_RESIDUALS]; ///< Learned: mean residual over mean flow; 0 before.
    float    sum[SD_AIRPATH_RESIDUALS];      ///< Of the window under way.
    float    flow_sum;                       ///< Of the same steps, g/s.
    uint32_t steps;                          ///< Of the window under way.
    uint8_t  learned;                        ///< 1: a window is complete.
    uint8_t  suspect;                        ///< 1: what was learned is as large as half of a fault of interest.
    uint8_t  reserved[2];
} sd_airpath_offsets_t;

/// Nothing learned.
void sd_airpath_offsets_start(sd_airpath_offsets_t *self);
/// The window under way is dropped; what was learned stays.
void sd_airpath_offsets_drop(sd_airpath_offsets_t *self);
/// A step of a healthy window of window_steps, (0, 1e6]. flow_gps > 0. True when it has completed the window.
bool sd_airpath_offsets_step(sd_airpath_offsets_t *self, uint32_t window_steps, const float *residual, float flow_gps);
/// Residuals minus what was learned, at this flow.
void sd_airpath_offsets_take(const sd_airpath_offsets_t *self, const float *residual, float flow_gps, float *out);

#ifdef __cplusplus
}
#endif
#endif
