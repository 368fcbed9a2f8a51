/* SPDX-License-Identifier: MIT */
/// sd_road.h - is the road rough? Chooses between two filters on tooth times (sd_kalman.h) that run side by side, one
/// with gains for a steady load, one with gains for a load that moves.
///
/// What a firing gave, both filters estimate from the same teeth. On a smooth road they differ by noise that the rough
/// one states, and by what is not known of the pulse, which is the same each cycle. So what counts is the change of the
/// difference from one cycle to the next, D, of the same firing:
///     evidence += (min(D^2 / limit^2, 4) - evidence) / 32,   limit^2 = (3.5 noise)^2 + (0.04 mean torque)^2
/// The road is rough from evidence 1 on, and smooth again below 0.5. On a smooth road D is 1.1 to 1.4 times the noise. A
/// misfire changes D of a few firings, and of each counts no more than 4: alone it cannot reach 1 (docs/theory/firing.md).
///
/// Both filters run always, so that there is nothing to settle when the choice changes.
///
/// Real-time contract: no heap, no globals, no libm; constant time. One writer. Call order: restart; step a firing.
#ifndef SD_ROAD_H
#define SD_ROAD_H
#include "sd_kalman.h"

#ifdef __cplusplus
extern "C" {
#endif

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_road {
    float   difference_nm[SD_KALMAN_FIRINGS_MAX]; ///< Of the last cycle, by firing.
    float   evidence; ///< [0, 4].
    uint8_t seen;     ///< Bit i: difference_nm[i] is known.
    uint8_t rough;        ///< 1: the filter for rough roads is believed.
} sd_road_t;

/// Differences from before are forgotten; what is known of the road stays. All zero is a valid start.
void sd_road_restart(sd_road_t *self);

/// Takes what both filters say of one firing; returns true while the road is rough. An index beyond
/// SD_KALMAN_FIRINGS_MAX, another index in *rough, or no number: nothing changes.
bool sd_road_step(sd_road_t *self, const sd_firing_t *smooth, const sd_firing_t *rough);

#ifdef __cplusplus
}
#endif

#endif
