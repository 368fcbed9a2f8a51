/* SPDX-License-Identifier: MIT */
/// sd_punctual.h - tooth periods of a wheel whose pattern is known, as an even wheel would give them.
///
/// A tooth that stands `late` rad behind its place passes late / omega after the time at which it should. Taking that from both ends of
/// a period gives the period between the places: period - late_k / omega + late_(k-1) / omega.
///
/// Times are whole ticks, and a tooth's lateness may be less than one, the same in every revolution: rounded for itself it would not be
/// corrected at all. So what is rounded off at a tooth goes into the next one. The error is then the difference of two roundings, of which
/// next to nothing is left in the low harmonics of the cycle, and no angle is lost.
///
/// For observers that know a tooth by its period (sd_fourier.h). Real-time contract: no heap, no globals, no libm; some 25 instructions.
#ifndef SD_PUNCTUAL_H
#define SD_PUNCTUAL_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// State; all 0 at the start.
typedef struct sd_punctual {
    int32_t late_ticks; ///< By which the last placed edge was taken to come later than its place would have, [-2^29, 2^28].
    float   left_ticks; ///< What late_ticks is short of, ticks, [-0.5, 0.5].
} sd_punctual_t;

/// The period that ends at a placed tooth, in ticks, at least 1 where one was given. `advance`: positions in it.
/// `late_rad`: of this tooth, rad. The period is returned as it is, and what is known of the last tooth forgotten, for a lateness of half
/// a pitch or more or no number, a period of 2^28 ticks or more, no advance, or a tooth that would stand before the last one.
/// `positions_per_rad`: of the wheel, N / 2 pi.
uint32_t sd_punctual_period(sd_punctual_t *self, uint32_t period_ticks, uint32_t advance, float late_rad, float positions_per_rad);

#ifdef __cplusplus
}
#endif

#endif
