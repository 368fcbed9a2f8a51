/* SPDX-License-Identifier: MIT */
/// sd_teeth.h - sums over the pairs of a tooth in the two revolutions of a cycle, taken tooth by tooth, so that no tooth has a pass over
/// all of them to do. Of sd_pattern and sd_twist.
#ifndef SD_TEETH_H
#define SD_TEETH_H

#ifdef __cplusplus
extern "C" {
#endif

/// k counts from the middle of the wheel, k = N / 2. d: lateness in the second revolution less that in the first, rad; a: both together,
/// rad; s: the same difference of the sensitivity to the modes' frequency, rad.
typedef struct sd_teeth_sums {
    float count, k, kk;  ///< Number of teeth; sum of k; sum of k^2.
    float a, d, kd, dd;  ///< Sum of a, d, k d and d^2.
    float s, ks, ss, sd; ///< Sum of s, k s, s^2 and s d.
} sd_teeth_sums_t;

/// Line of least squares through values of sums v and kv: level in the middle, and slope a position.
static inline void sd_teeth_line(const sd_teeth_sums_t *sums, float v, float kv, float *level, float *slope) {
    *slope = (sums->count * kv - sums->k * v) / (sums->count * sums->kk - sums->k * sums->k);
    *level = (v - *slope * sums->k) / sums->count;
}

#ifdef __cplusplus
}
#endif

#endif
