/* SPDX-License-Identifier: MIT */
/// sd_hidden.h - a tooth pattern that looks exactly like torque of the firings, told from it by fuel and speed. Of sd_fired.h.
///
/// Read as torque, such a pattern p (rad) grows with J w^2, and the torque of a commanded fuel does not:
///     z = k fuel + o charge + e mean + p J w^2
/// k, N m/mg, belongs to the engine and its injectors, o, N m/bar, to a motored torque that the calibration has wrong. e is what
/// efficiency and friction add, a share of the mean torque of all firings; it stays the same while speed and fuel do, and is another one
/// elsewhere, so that time at one point of the map does not make it average out. A Kalman filter of these four states.
///
/// Real-time contract: no heap, no globals, no libm; constant time, once a cycle. Plain data without pointers.
#ifndef SD_HIDDEN_H
#define SD_HIDDEN_H
#include "sd_math.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Coefficients of a direction's reading, in the order of the head of this file.
enum {
    SD_HIDDEN_FUEL,    ///< k, N m per mg.
    SD_HIDDEN_CHARGE,  ///< o, N m per bar.
    SD_HIDDEN_MEAN,    ///< e, share of the mean torque.
    SD_HIDDEN_PATTERN, ///< p, rad.
    SD_HIDDEN_STATES   ///< Their number.
};

/// What is known of one. Kept when the engine is off. All 0: nothing is known yet.
typedef struct sd_hidden {
    float x[SD_HIDDEN_STATES];  ///< Coefficients k, o, e, p.
    float c[SD_HIDDEN_STATES * (SD_HIDDEN_STATES + 1) / 2]; ///< Their variances and covariances: row i, column j <= i at i (i + 1) / 2 + j.
    float speed_radps, fuel_mg; ///< Operating point that e belongs to.
} sd_hidden_t;

/// What a cycle says of it.
typedef struct sd_hidden_reading {
    float z_nm;      ///< What the firings read in this direction, as if there were no pattern in it, N m.
    float fuel_mg;   ///< Commanded for a firing, above 0.
    float charge_bar; ///< Mean of the cylinders' intake pressure.
    float mean_nm;   ///< Mean torque of all firings.
    float scale_nm;  ///< J w^2.
    float speed_radps; ///< Of the crank.
    float variance;  ///< Of z, from cycle to cycle, (N m)^2, above 0.
} sd_hidden_reading_t;

/// Takes a reading. size: what 1 N m in every firing, alternating as the direction does, makes of z. doubt: standard deviation of e over
/// size. common: all firings alike, so that k is the torque of a mg and not what firings differ by. prior_rad: standard deviation of p
/// before anything is known.
void sd_hidden_step(sd_hidden_t *self, const sd_hidden_reading_t *reading, float size, float doubt, bool common, float prior_rad);

/// Whether kept ones may be real: no deviation squared is below 0.
bool sd_hidden_ok(const sd_hidden_t *self);

/// Variance of p, rad^2.
float sd_hidden_variance(const sd_hidden_t *self, float prior_rad);

#ifdef __cplusplus
}
#endif

#endif
