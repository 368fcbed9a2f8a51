/* SPDX-License-Identifier: MIT */
/// sd_punctual.h - tooth periods of a wheel whose pattern is known, as an even wheel would give them.
///
/// A tooth that stands `late` rad behind its place passes late / omega after the time at which it should. Taking that from both ends of
/// a period gives the period between the places: period - late_k / omega + late_(k-1) / omega. The moves are whole ticks of edge times,
/// so what is rounded at one tooth comes back at the next and no angle is lost.
///
/// For observers that know a tooth by its period (sd_fourier.h). Real-time contract: no heap, no globals, no libm; some 20 instructions.
#ifndef SD_PUNCTUAL_H
#define SD_PUNCTUAL_H
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SD_PUNCTUAL_PERIOD_MAX 0x10000000u /* ticks; longer ones are no turning */

/// State; 0 at the start.
typedef struct sd_punctual {
    int32_t late_ticks; ///< By which the last placed edge came later than its place would have.
} sd_punctual_t;

/// The period that ends at a placed tooth, in ticks, at least 1 where one was given. `advance`: positions in it, at least 1.
/// `late_rad`: of this tooth, rad; half a pitch or more is taken for 0. `positions_per_rad`: of the wheel, N / 2 pi.
static inline uint32_t sd_punctual_period(sd_punctual_t *self, uint32_t period_ticks, uint32_t advance, float late_rad,
                                          float positions_per_rad) {
    const float late = late_rad * positions_per_rad;
    const int32_t since = (int32_t)(period_ticks & (SD_PUNCTUAL_PERIOD_MAX - 1u)) + self->late_ticks; /* from the last tooth's place */
    const bool turns = (period_ticks > 0u) && (period_ticks < SD_PUNCTUAL_PERIOD_MAX) && (late > -0.5f) && (late < 0.5f);
    self->late_ticks = 0;
    if (!turns) { return period_ticks; }
    const float ticks = late * (float)since / ((float)advance + late);
    self->late_ticks = (int32_t)((ticks < 0.0f) ? ticks - 0.5f : ticks + 0.5f);
    const int32_t even = since - self->late_ticks;
    return (even > 0) ? (uint32_t)even : 1u;
}

#ifdef __cplusplus
}
#endif

#endif
