/* SPDX-License-Identifier: MIT */
/// sd_fired.h - learns where each tooth of the wheel really is while the engine fires.
///
/// Over a cycle an estimate runs free from what the filter knew at its start (sd_kalman.h). Lateness against it is
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
/// Who owns what. Teeth collect L of every cycle in one of two places, and no more; the 10 ms task works at a cycle that was seen whole,
/// and may be interrupted by teeth at any instruction:
///     sd_fired_hand_over   between two teeth: the cycle that waits is the task's
///     sd_fired_work        the task: it reads that cycle and the pattern in use, and writes the sums, `task` and the pattern not in use
///     sd_fired_take_over   between two teeth, when the task is done: the cycle's place is free, and a new pattern is in use
/// What teeth do between the first and the last changes nothing of what the task reads, so that the result is the same however they
/// interrupt it. A cycle is longer than 10 ms up to 12,000 rpm; one that ends while the last one still waits is left out.
///
/// Real-time contract: as sd_motion.h. The task has two passes over the wheel for a cycle, and two more where it places the pattern anew.
/// Call sd_fired_step for each placed tooth while the filter has settled and fuel burns, sd_fired_rest for any other.
#ifndef SD_FIRED_H
#define SD_FIRED_H
#include "sd_hidden.h"
#include "sd_kalman.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_FIRED_CYCLES_MIN 4     ///< Cycles before a pattern is given at all.
#define SD_FIRED_UNIT_RAD   1e-5f ///< Of a lateness that waits for the task: 0.0006 deg.

/// What is kept when the engine is off. Owned by the task.
typedef struct sd_fired_sums {
    float cycles, psi, psi2;                    ///< Sum of 1, psi, psi^2 over cycles.
    float square;                               ///< Sum over cycles of the mean over teeth of m^2.
    float late[SD_KALMAN_POSITIONS_MAX];        ///< Sum of m over cycles, rad.
    float late_psi[SD_KALMAN_POSITIONS_MAX];    ///< Sum of psi m over cycles, rad.
    sd_hidden_t hidden[SD_KALMAN_HIDDEN_MAX];
} sd_fired_sums_t;

/// A cycle as teeth saw it, and as the filter had it at its start.
typedef struct sd_fired_cycle {
    sd_pair_t late[SD_KALMAN_POSITIONS_MAX]; ///< L in the first and in the second revolution, in SD_FIRED_UNIT_RAD.
    float psi, scale_nm;   ///< Mean torque over J w^2; J w^2.
    float charge_bar;      ///< Mean of the cylinders.
    float fuel_mg;         ///< Commanded for a firing; below 0: not known.
    float firing_nm[SD_KALMAN_FIRINGS_MAX]; ///< Torque of each firing, as the filter had it.
    uint8_t steady;        ///< 1: the commanded fuel has not moved lately, and the filter had its teeth corrected.
} sd_fired_cycle_t;

/// The pattern, as it stood after `cycles`.
typedef struct sd_fired_pattern {
    float late_rad[SD_KALMAN_POSITIONS_MAX]; ///< 0 where there is no tooth.
    float sd_rad;         ///< Its standard deviation, rms over the teeth, hidden directions included; 0: nothing learned.
    float tooth_rad;      ///< The same without hidden directions.
    float found_rad;      ///< Its rms over the teeth.
    float hidden_share;   ///< Standard deviation of a firing less the mean of all that hidden directions leave, over J w^2.
    float cycles;         ///< Number of cycles that it was learned in.
} sd_fired_pattern_t;

/// What only the task touches.
typedef struct sd_fired_task {
    float known[SD_KALMAN_PARTS_MAX]; ///< Q' S of the pattern without hidden directions, rad.
    float left_rad2;      ///< Variance that the fit leaves of a tooth in a cycle.
    uint8_t since;        ///< Cycles since the pattern was placed.
    uint8_t placed;       ///< 1: the pattern that is not in use is a new one.
} sd_fired_task_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_fired {
    sd_fired_cycle_t cycle[2];
    sd_fired_pattern_t pattern[2];
    sd_fired_task_t task;
    float unlearned_rad;  ///< Standard deviation of a tooth's place while nothing is learned. The caller's to set.
    float fuel_mg;        ///< Commanded at the start of the cycle under way; below 0: not known.
    uint8_t steady;       ///< Cycles since the commanded fuel changed, saturating.
    uint8_t following;    ///< 1: the cycle under way was seen from its start.
    uint8_t collects;     ///< Which cycle teeth write.
    uint8_t waits;        ///< 1: the other one was seen whole and is not in the sums yet.
    uint8_t handed;       ///< 1: the task has it.
    uint8_t used;         ///< Which pattern is in use.
    uint16_t teeth;       ///< Taken in the cycle under way.
} sd_fired_t;

/// Forgets everything that is not in the sums.
void sd_fired_init(sd_fired_t *self);
/// Takes up kept sums; *tables has passed sd_kalman_init. For a start, not for a tooth, nor while the task has a cycle.
void sd_fired_resume(sd_fired_t *self, const sd_kalman_tables_t *tables, const sd_fired_sums_t *sums);
/// Whether *sums may be of such a wheel.
bool sd_fired_sums_ok(const sd_fired_sums_t *sums, const sd_kalman_tables_t *tables);

/// The pattern in use.
static inline const sd_fired_pattern_t *sd_fired_used(const sd_fired_t *self) { return &self->pattern[self->used]; }

/// A trusted tooth while fuel burns, after the settled filter has taken it; at tooth 0 it lets the filter's free estimate begin anew.
/// fuel_mg: commanded, below 0 where it is not known. corrected: the filter has the teeth corrected by a learned pattern; what it reads
/// without is too far off to tell of hidden directions. A tooth out of range changes nothing.
void sd_fired_step(sd_fired_t *self, const sd_kalman_tables_t *tables, sd_kalman_t *kalman, uint32_t cycle_position, float fuel_mg,
                   bool corrected);
/// Any other tooth: the cycle under way is dropped.
void sd_fired_rest(sd_fired_t *self, sd_kalman_t *kalman);

/// The three steps of the task, above. sd_fired_take_over returns true when the pattern changed.
void sd_fired_hand_over(sd_fired_t *self);
void sd_fired_work(sd_fired_t *self, const sd_kalman_tables_t *tables, sd_fired_sums_t *sums);
bool sd_fired_take_over(sd_fired_t *self);

#ifdef __cplusplus
}
#endif

#endif
