/* SPDX-License-Identifier: MIT */
/// sd_fired.h - learns where each tooth of the wheel really is while the engine fires.
///
/// Over a cycle the prediction runs free from what the filter knows at its start (sd_kalman.h). Lateness against it is
///     L = S d + H t + noise
/// S d being the pattern d, once in each revolution, and H t what phase, energy, load and firings make of it that are not as the filter
/// had them. Normalised to J w^2, H is the same at every speed and load. The page holds its columns at right angles, Q, and so
///     m = mean over both revolutions of L - Q Q' L
/// is what of the pattern cannot be torque: nearly all of it, at any operating point. With A = mean of both revolutions of Q,
///     d = m + A (restore A' m) + sum of p_i v_i
/// where v_i are the few hidden directions (of four cylinders that fire evenly two: all firings larger, and every second one) that look
/// exactly like torque.
///
/// A pulse that is not as the calibration has it shows in m too, but in proportion to psi = mean torque / (J w^2), and a pattern does
/// not: each tooth is fitted as pattern + slope psi, with a prior for the slope. At one operating point the slope stays in the pattern,
/// and the deviation says so.
///
/// p_i, what the pattern has of a hidden direction, is learned from commanded fuel and speed (sd_hidden.h), when Q' S d of what is known of
/// the pattern is taken out of the reading, which is restore A' m. Without commanded fuel nothing is learned of p_i: a load that grows
/// with w^2 looks the same.
///
/// Every second cycle is learned from: in one the prediction runs, in the next what it saw is worked at, a piece a tooth.
///
/// Real-time contract: as sd_motion.h. No tooth has a pass over the wheel to do. Call sd_fired_step for each placed tooth while the
/// filter has settled and fuel burns, sd_fired_rest for any other.
#ifndef SD_FIRED_H
#define SD_FIRED_H
#include "sd_hidden.h"
#include "sd_kalman.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_FIRED_CYCLES_MIN 4 ///< Cycles before a pattern is given at all.

/// What is kept when the engine is off.
typedef struct sd_fired_sums {
    float cycles, psi, psi2;                    ///< Sum of 1, psi, psi^2 over cycles.
    float square;                               ///< Sum over cycles of the mean over teeth of m^2.
    float late[SD_KALMAN_POSITIONS_MAX];        ///< Sum of m over cycles, rad,
    float late_psi[SD_KALMAN_POSITIONS_MAX];    ///< and of psi m.
    float part[SD_KALMAN_PARTS_MAX];            ///< Sum of A' m over cycles, rad,
    float part_psi[SD_KALMAN_PARTS_MAX];        ///< and of psi A' m.
    sd_hidden_t hidden[SD_KALMAN_HIDDEN_MAX];
} sd_fired_sums_t;

/// What is to do with a cycle that was seen, a piece a tooth.
typedef enum sd_fired_phase {
    SD_FIRED_RESTS,   ///< Nothing.
    SD_FIRED_READS,   ///< It tells of hidden directions, one a piece,
    SD_FIRED_SUMS,    ///< goes into the sums, a position a piece,
    SD_FIRED_WEIGHS,  ///< the sums say how pattern and slope come from them,
    SD_FIRED_PLACES,  ///< and the pattern is placed, a position a piece.
} sd_fired_phase_t;

/// A cycle on its way into the sums, and the pattern's way out of them.
typedef struct sd_fired_work {
    uint8_t  phase;    ///< sd_fired_phase_t
    uint8_t  next;     ///< Direction or position that comes next.
    float part[SD_KALMAN_PARTS_MAX];   ///< What A is multiplied with while the pattern is placed.
    float of_late[SD_KALMAN_PARTS_MAX]; ///< A' m of the cycle.
    float weight, weight_psi, weight_psi2; ///< Inverse of the sums' matrix: constant by `weight` late + `weight_psi` late_psi.
    float square;      ///< Over the positions done: of m squared; while it is placed of the pattern squared,
    float explained;   ///< and of what pattern and slope explain of the sums.
} sd_fired_work_t;

typedef struct sd_fired {
    float late_rad[SD_KALMAN_POSITIONS_MAX]; ///< The pattern; 0 where there is no tooth.
    float sd_rad;         ///< Its standard deviation, rms over the teeth, hidden directions included; 0: nothing learned.
    float tooth_rad;      ///< The same without hidden directions.
    float found_rad;      ///< Its rms over the teeth.
    float unlearned_rad;  ///< Standard deviation of a tooth's place while nothing is learned. The caller's to set.
    float hidden_share;   ///< Standard deviation of a firing less the mean of all that hidden directions leave, over J w^2.
    float known[SD_KALMAN_PARTS_MAX]; ///< Q' S of the pattern without hidden directions.
    float left_rad2;      ///< Variance that the fit leaves of a tooth in a cycle.
    sd_fired_work_t work;
    sd_motion_t free;     ///< Prediction of the cycle under way,
    sd_motion_charge_t charge; ///< and the cylinders' charges in it.
    float part[SD_KALMAN_PARTS_MAX]; ///< Q' L of the cycle under way, or the one that is on its way into the sums.
    float psi, scale_nm;  ///< Of the same cycle; J w^2.
    float fuel_mg;        ///< Commanded at its start; below 0: not known.
    uint8_t steady;       ///< Cycles learned from since the commanded fuel changed, saturating.
    uint8_t pause;        ///< Cycles before the next one is learned from.
    uint8_t following;    ///< The cycle under way was seen from its start.
    uint16_t teeth;       ///< Taken in the cycle under way.
} sd_fired_t;

/// Forgets everything that is not in the sums.
void sd_fired_init(sd_fired_t *self);
/// Takes up kept sums; *tables has passed sd_kalman_init. Passes over the whole wheel: for a start, not for a tooth.
void sd_fired_resume(sd_fired_t *self, const sd_kalman_tables_t *tables, const sd_fired_sums_t *sums);
/// Whether *sums may be of such a wheel.
bool sd_fired_sums_ok(const sd_fired_sums_t *sums, const sd_kalman_tables_t *tables);

/// A trusted tooth while fuel burns, after the settled filter has taken it. cycle_rad has room for a cycle, and belongs to this block
/// for the cycle that it sees and the next. fuel_mg: commanded, below 0 where it is not known. corrected: the filter has the teeth
/// corrected by a learned pattern; what it reads without is too far off to tell of hidden directions. burdened: the tooth has other
/// work than its own.
/// Returns true when the pattern changed.
bool sd_fired_step(sd_fired_t *self, const sd_kalman_tables_t *tables, sd_fired_sums_t *sums, float *cycle_rad, const sd_kalman_t *kalman,
                   const sd_kalman_tooth_t *tooth, float fuel_mg, bool corrected, bool burdened);
/// Any other tooth: the cycle under way is dropped; one that was seen whole is worked at. Returns true when the pattern changed.
bool sd_fired_rest(sd_fired_t *self, const sd_kalman_tables_t *tables, sd_fired_sums_t *sums, const float *cycle_rad);

#ifdef __cplusplus
}
#endif

#endif
