/* SPDX-License-Identifier: MIT */
/// sd_pattern.h - learns where each tooth of the wheel really is, while the engine is motored (fuel cut).
///
/// Without combustion the torque is known but for a constant, so over one cycle the filter's prediction runs free from
/// a guessed energy and constant torque, and each tooth's lateness L_k (rad) against it is
///     L_k = pattern of the tooth + c + a_1 k + a_2 k^2 + error of the motored torque / (J w^2) + jitter.
/// The same tooth one revolution later has the same pattern, so the differences L_(k+N) - L_k give a_1 and a_2 without
/// it; both then improve the guess for the next cycle. What is left, averaged over cycles, is the pattern. A wrong
/// motored torque looks like a pattern of the engine's orders, but shrinks with 1 / w^2: each tooth is fitted as
///     pattern + u slope,  u = (w_ref / w)^2,
/// once the cycles seen span enough speed; until then as a constant, and the confidence says so.
///
/// Before that, what an exponent of compression larger by c makes of every tooth is taken out, r c S_k with r = u times the mean charge
/// and S_k from the tables (SD_ROW_LATE). That one number belongs to the engine at every speed, and a pattern does not look like S_k:
///     c = (sum r <S, L> - sum r <S, sum L> / (n + kappa)) / (|S|^2 (sum r^2 - (sum r)^2 / (n + kappa)) + v / SD_c^2)
/// over n cycles, with v the variance that the fit leaves of a tooth and kappa that over the pattern's. So a motored torque that is wrong
/// at one speed is not taken for a pattern at all others.
///
/// And the zero of each cylinder: what the filter reads of it without combustion, for a bar of its charge. A compression
/// or a trapped mass that the calibration has wrong shows there, and would be taken for torque when the engine fires. Only
/// differences from the mean of all cylinders are kept; a timing error makes a torque of w^2, hence the weight u^2.
///
/// Real-time contract: as sd_motion.h. No tooth has a pass over the wheel to do: what a cycle's end takes is summed tooth by
/// tooth, and its lateness goes into the sums a few positions a tooth during the next revolution, before it is written over.
/// Call sd_pattern_step for each placed tooth while fuel is cut, sd_pattern_rest for any other.
#ifndef SD_PATTERN_H
#define SD_PATTERN_H
#include "sd_fired.h"
#include "sd_twist.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_PATTERN_CYCLES_MIN 4 ///< Cycles before a pattern is given at all.
#define SD_PATTERN_REFERENCE_RADPS 200.0f ///< w_ref.
#define SD_PATTERN_EXPONENT_MAX 0.15f     ///< Largest |c|.

/// What is kept when the engine is off: with it, learning goes on where it ended.
typedef struct sd_pattern_sums {
    float cycles, u, uu;                    ///< Sum of 1, u, u^2 over cycles.
    float r, rr, ur;                        ///< Sum of r, r^2, u r over cycles; r in bar.
    float late_common;                      ///< Sum of r <S, L> over cycles, rad^2.
    float late[SD_KALMAN_POSITIONS_MAX];    ///< Sum of L, trend taken out, over cycles.
    float late_u[SD_KALMAN_POSITIONS_MAX];  ///< Sum of u L, rad.
    float square;                           ///< Sum over cycles of the mean over teeth of L^2.
    float zero[SD_KALMAN_FIRINGS_MAX];      ///< Sum of u^2 (reading of cylinder i over its charge), Nm/bar.
    float zero_u2[SD_KALMAN_FIRINGS_MAX];   ///< Sum of u^2 over the same cycles.
    sd_twist_sums_t twist;
    sd_fired_sums_t fired;                  ///< While the engine fires (sd_fired.h); untouched here.
} sd_pattern_sums_t;

/// The last cycle's lateness on its way into the sums.
typedef struct sd_pattern_work {
    uint16_t next;   ///< Position that comes next; N: nothing is on its way.
    float a1, a2;    ///< Trend a position, and a position squared.
    float mean_rad;  ///< Mean of both revolutions over all teeth, trend taken out.
    float u;         ///< (w_ref / w)^2 of the cycle.
    float r;         ///< u times the mean charge, bar.
    float scale_nm;  ///< J w^2 of the cycle.
    float exponent;  ///< c that is taken out.
    /// Sums over the positions done, rad^2: lateness squared; what pattern and slope explain of the sums; the pattern squared; <S, L> of
    /// this cycle; <S, sum L>; |S|^2.
    float square, explained, pattern_square, late_common, late_common_sums, common_square;
} sd_pattern_work_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_pattern {
    sd_pattern_sums_t sums;
    float late_rad[SD_KALMAN_POSITIONS_MAX]; ///< The pattern, mean 0; 0 where there is no tooth.
    float sd_rad;         ///< Its standard deviation, a tooth; 0: nothing learned.
    float exponent;       ///< c that was taken out of it, of SD_PATTERN_EXPONENT_MAX at most; 0: nothing learned.
    float exponent_sd;    ///< Standard deviation of that exponent; that of no knowledge while nothing is learned.
    float exponent_next;  ///< The exponent as the sums have it now: c of the next cycle.
    uint8_t pooled;       ///< 1: the speeds seen tell pattern from motored torque.
    sd_pattern_work_t work;
    sd_motion_t free;     ///< Prediction of the cycle under way.
    sd_motion_charge_t charge; ///< The cylinders' charges in that cycle.
    sd_motion_tuning_t tuning; ///< Frequencies of the crank's modes in that cycle.
    sd_twist_t twist;     ///< Frequencies of a crank that twists.
    float energy_j, constant_nm; ///< Guess for the cycle under way: at its start, and throughout.
    float cycle_rad[2 * SD_KALMAN_POSITIONS_MAX]; ///< L of the cycle under way.
    sd_teeth_sums_t pairs;///< Of the cycle under way.
    float ripple_square;  ///< Sum over its positions of the motored torque squared.
    float ripple_nm;      ///< Rms of the motored torque of the last cycle.
    uint16_t teeth;       ///< Taken in the cycle under way.
    uint8_t following;    ///< The cycle under way was seen from its start.
    uint8_t guessed;      ///< Cycles since the guess began anew, saturating.
} sd_pattern_t;

/// Forgets everything. *tables has passed sd_kalman_init.
void sd_pattern_init(sd_pattern_t *self, const sd_kalman_tables_t *tables);
/// Goes on from kept sums. SD_ERR_CONFIG, and nothing changed, when they are not finite or not of such a wheel. Passes over
/// the whole wheel: for a start, not for a tooth.
sd_result_t sd_pattern_resume(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_pattern_sums_t *sums);
/// What to keep: the sums, with a cycle that is on its way in them. Passes over the whole wheel: for the end, not for a tooth.
void sd_pattern_keep(const sd_pattern_t *self, const sd_kalman_tables_t *tables, sd_pattern_sums_t *sums);
/// A tooth without fuel in any cylinder; late_rad and pattern_rad are not used. Returns true when the pattern changed.
bool sd_pattern_step(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_kalman_tooth_t *tooth);
/// Any other tooth: the cycle under way is dropped; one that is on its way into the sums is not. Returns true when the pattern
/// changed.
bool sd_pattern_rest(sd_pattern_t *self, const sd_kalman_tables_t *tables);
/// The angle is lost: the cycle under way is dropped.
void sd_pattern_pause(sd_pattern_t *self);
/// A firing that the filter read while fuel is cut, its charge and the speed. Returns true when all cylinders have a zero.
bool sd_pattern_take_zero(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_firing_t *firing, float charge_bar,
                          float speed_radps);
/// The zeros, Nm/bar by firing: all 0 before every cylinder was read.
void sd_pattern_zeros(const sd_pattern_t *self, const sd_kalman_tables_t *tables, float *zero_nm_per_bar);

#ifdef __cplusplus
}
#endif

#endif
