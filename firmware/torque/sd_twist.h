/* SPDX-License-Identifier: MIT */
/// sd_twist.h - learns at what frequencies a crank twists, while the engine is motored (fuel cut).
///
/// sd_pattern.h lets the prediction run free over a cycle of known torque. Beside it runs the same prediction with all
/// modes a little faster; by how much later its teeth are expected is the sensitivity S_k. The difference of the same
/// tooth's lateness L in two revolutions,
///     L_(k+N) - L_k = c_0 + c_1 k - (S_(k+N) - S_k) (f / f_tables - 1) + noise,
/// holds no tooth pattern, but the half orders of the engine, by which cylinders at different places twist the crank.
/// Least squares over a cycle is Gauss and Newton's step; a Kalman filter of one state weighs it by its variance: what the
/// fit leaves, and an error of the model. A step widens the variance by half its own square: near resonance a mode is far
/// from linear in its frequency, and what was learned far from the truth must not weigh.
///
/// One number for all modes: they stand on the same springs. A mode that no order comes near does not mind.
///
/// Real-time contract: as sd_motion.h; a tooth costs one more prediction, a cycle's end constant time: the sums that the fit
/// takes are gathered tooth by tooth (sd_teeth.h). Owned and called by sd_pattern.h.
#ifndef SD_TWIST_H
#define SD_TWIST_H
#include "sd_motion.h"
#include "sd_teeth.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What is kept when the engine is off.
typedef struct sd_twist_sums {
    float deviation; ///< Of the modes' frequency from the tables', as a share, [-0.1, 0.1].
    float variance;  ///< Of that, from jitter and what its steps leave; 0 without modes.
    float bias;      ///< What an error of the model may make of the deviation, a share; it does not average out.
} sd_twist_sums_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_twist {
    sd_motion_t trial; ///< The free prediction with modes a little faster.
    sd_motion_tuning_t tuning; ///< Of the trial.
    float sensitivity_rad[SD_KALMAN_POSITIONS_MAX]; ///< S of each tooth in the first revolution of the cycle under way.
    float unknown_rad; ///< Rms that the deviation's variance gives the differences of the last cycle; 0: none yet.
} sd_twist_t;

/// Forgets everything.
void sd_twist_init(sd_twist_t *self, const sd_kalman_tables_t *tables, sd_twist_sums_t *sums);
/// Whether they are in range, and of such a crank; false for NaN.
bool sd_twist_sums_ok(const sd_twist_sums_t *sums, const sd_kalman_tables_t *tables);
/// Standard deviation of the deviation, a share, from variance and bias together; 0 without modes.
float sd_twist_sd(const sd_twist_sums_t *sums);
/// The frequencies as learned.
sd_motion_tuning_t sd_twist_tuning(const sd_twist_sums_t *sums);
/// A cycle begins where the free prediction stands.
void sd_twist_begin(sd_twist_t *self, const sd_kalman_tables_t *tables, const sd_motion_t *free, const sd_motion_tuning_t *tuning);
/// Moves the trial over an interval. False when its crank would stand still.
bool sd_twist_predict(sd_twist_t *self, const sd_kalman_tables_t *tables, const sd_motion_row_t *row);
/// Tooth k of the cycle, period_s after the last one: the free prediction's lateness is late_rad there. In the second
/// revolution the tooth's sensitivity goes into the sums, with the difference d of its lateness.
void sd_twist_follow(sd_twist_t *self, const sd_kalman_tables_t *tables, uint32_t k, float period_s, float late_rad, float d,
                     sd_teeth_sums_t *pairs);
/// The cycle's end: learns from the pairs, takes what it learned out of them, and moves *free as if it had known.
void sd_twist_learn(sd_twist_t *self, const sd_kalman_tables_t *tables, sd_twist_sums_t *sums, sd_teeth_sums_t *pairs, sd_motion_t *free);
/// Whether the frequencies are known so well that what is left of a cycle is pattern. True without modes.
bool sd_twist_known(const sd_twist_t *self, const sd_kalman_tables_t *tables);

#ifdef __cplusplus
}
#endif

#endif
