/* SPDX-License-Identifier: MIT */
/// sd_kalman.h - periodic Kalman filter on tooth times: torque of each single firing, from crank teeth.
///
/// The measurement is the time of a tooth edge, not a speed: edge jitter is white there, and a gap in the wheel is three
/// predictions without a correction. State: lateness tau (s), kinetic energy e (J), coefficients x (Nm) of
///     T(alpha) = known(alpha) + x_0 + sum over j >= 1 of x_j f_j(alpha)
/// known is the motored torque, each cylinder's for the intake pressure when its valve closed; x_0 is everything
/// constant: less load, less friction.
/// With the pulse basis f_j is the combustion torque of firing j, mean 1 over the 180 deg after its TDC, so that x_j is
/// that cylinder's mean combustion torque; with the Fourier basis it is cos and sin of harmonics. The kernel knows only
/// tables. Pulses may have a shape to learn: f_j + shape g_j in place of f_j, one number for all cylinders; what their mean
/// torque's share of the gain K_s says of it. One tooth position, d the pitch (derivation: docs/theory/firing.md):
///     dt   = d sqrt(J_interval / (2 (e + d (moment of T))))      time over the interval, by its mean energy
///     e   += d (mean of T),  tau += dt
/// and at a tooth that is there, w = sqrt(2 e / J_tooth), s = J_mean w^2, r its lateness in rad against the prediction:
///     tau -= measured period,  tau += K_0 r / w,  e += K_1 r s,  x += K_x r s
/// A crank that twists, or a dual-mass flywheel, adds modes: each moves the wheel by its twist q ahead of the rigid
/// crank, which r counts, and over an interval, F being the twist that its mean torques would hold,
///     (q - F, v) <- exp(w_m dt [0 1; -1 -2 z]) (q - F, v),  F = sum of compliance_i (torque of cylinder i) + known + ripple w^2
/// v being its rate over w_m; q += K_q r, v += K_v r. Energy and inertia are then those of all that turns, the
/// secondary mass included.
///
/// K is a table over cycle position and speed, from the periodic Riccati equation (`sixdeg calibrate`), zero where the
/// wheel has no tooth, linear between speeds and constant beyond them. Until it has settled, the filter takes the gains
/// of half its speed, which let it move further; not where there are modes, whose swing over a pitch depends on speed. A
/// second set of gains is made for rough roads, where the load walks further from tooth to tooth: a second filter runs with
/// it beside the first on the same teeth, charges and pulses, and sd_road.h chooses.
///
/// Firing torque: x_j as it stands at the read position of firing j, a good half turn after its pulse.
///
/// Real-time contract: no heap, no globals, no libm. The known torque of a position is summed once for all filters. One
/// writer per state. Tables are read only, may be shared and may stand in flash. Call order: init; step for every placed
/// tooth; restart after lost sync or a stall. Instructions on a Cortex-M7: docs/results/firing.md.
#ifndef SD_KALMAN_H
#define SD_KALMAN_H
#include "sd_motion.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_KALMAN_SHAPE_MIN (-1.0f) ///< Least shape of the pulses: no wall loss.
#define SD_KALMAN_SHAPE_MAX 3.0f    ///< Largest shape: four times the calibration's wall loss.
#define SD_KALMAN_MEAN 10 ///< Cycles that a cylinder's mean torque is taken over.

/// What may change while the filter runs, and needs no restart then. It stands in the state, because tables are constant.
typedef struct sd_kalman_choice {
    float    torque_base_nm; ///< Highest |coefficient|, [1e-3, 20000]; beyond it the filter starts anew.
    float    reject_rad;     ///< Lateness beyond which a tooth is left out, besides what a torque explains, [1e-6, 1]; once
                             ///< settled it is 8 times the innovation as met.
    uint16_t settle_teeth;   ///< Teeth until the estimate counts as converged, any number.
} sd_kalman_choice_t;

/// A placed tooth.
typedef struct sd_kalman_tooth {
    uint16_t cycle_position; ///< [0, 2 N).
    uint16_t advance;        ///< Positions since the last one, 1 to 2 N.
    uint32_t period_ticks;   ///< Time since the last one.
    uint8_t  trusted;        ///< 0: predict only.
    float    late_rad;       ///< Learned error of this tooth, positive when its edge comes late.
    float    pattern_rad;    ///< Standard deviation of what is not learned of it.
    float    hidden_share;   ///< Standard deviation of a firing less the mean of all, over J w^2, from patterns that look like torque.
    float    intake_bar;     ///< Intake pressure, [0, 10]; anything else, NaN included: the last good one is held.
} sd_kalman_tooth_t;

/// One firing: sent when its estimate is complete.
typedef struct sd_firing {
    uint8_t index;      ///< In firing order.
    float   raw_nm;     ///< torque_nm before zero_nm_per_bar was taken out.
    float   torque_nm;  ///< Mean combustion torque over the 180 deg after its TDC.
    float   sd_nm;      ///< Standard deviation of that less the mean of all cylinders (of one cylinder, of itself): timing noise as met,
                        ///< what is not known of the engine, and with the gains for rough roads what the load's walk gives.
    float   noise_nm;   ///< From timing errors that are new at each edge: as met, and no less than the gains were made for.
    float   mean_nm;    ///< Of this cylinder's last SD_KALMAN_MEAN cycles, fewer after a start.
    float   mean_sd_nm; ///< Standard deviation of mean_nm, as sd_nm.
} sd_firing_t;

/// What the tables say at a filter's speed, looked up every fourth tooth: in so few the speed hardly changes.
typedef struct sd_kalman_place {
    sd_pair_t weight;        ///< Of the lower and the upper of two speeds.
    float     expected_rad;  ///< Rms of the innovation.
    float     per_expected;  ///< 1 over that.
    uint8_t   at;            ///< The lower speed.
    uint8_t   of;            ///< 0: nothing yet; 1: the filter was settling; 2: it had settled.
} sd_kalman_place_t;

/// One filter: its estimate, and what it knows of itself.
typedef struct sd_kalman_filter {
    sd_motion_t motion;      ///< The estimate.
    float    innovation_rad; ///< Lateness of the last corrected tooth against its prediction.
    float    jitter_square;  ///< Square of the lateness that jitter explains, rad^2: the innovation was held against that first.
    float    noise_ratio;    ///< Running mean square of the innovation over its expectation.
    float    peak_nm;        ///< Largest |coefficient|, looked up every fourth tooth.
    sd_kalman_place_t place;
    float    ring_nm[SD_KALMAN_FIRINGS_MAX][SD_KALMAN_MEAN]; ///< Last torques of each cylinder.
    uint8_t  kept[SD_KALMAN_FIRINGS_MAX]; ///< Filled places of each ring.
    uint8_t  next[SD_KALMAN_FIRINGS_MAX]; ///< Where the next firing goes.
    uint16_t teeth;          ///< Since restart, saturating.
    uint16_t rejected;       ///< Teeth left out since init, saturating.
    uint16_t rejected_in_row;///< Teeth left out since the last one that was taken.
    uint8_t  running;        ///< 1: the estimate follows the teeth.
} sd_kalman_filter_t;

/// One filter, or two beside each other, and what they share.
typedef struct sd_kalman {
    sd_motion_charge_t charge; ///< Of the cylinders; kept by restart.
    float    shape;       ///< Of the pulses, times the wall loss, [SD_KALMAN_SHAPE_MIN, SD_KALMAN_SHAPE_MAX], kept by restart.
    /// What each cylinder reads without combustion, over its charge; 0: not learned; kept by restart.
    float    zero_nm_per_bar[SD_KALMAN_FIRINGS_MAX];
    sd_motion_tuning_t tuning; ///< Kept by restart.
    float    tick_s;      ///< 1 / tick_hz.
    float    known_nm;    ///< Motored torque at the last tooth.
    sd_kalman_choice_t choice; ///< Kept by restart; may be changed between two steps to another that sd_kalman_choice_ok takes.
    /// An estimate over the same intervals and charges, with pulses whose shape is 0, that no tooth corrects: sd_kalman_set_free.
    sd_motion_t free;
    uint8_t  free_runs;   ///< 1: it moves with each step. 0: nobody began it, it would have stood still, or the filters began anew.
    uint8_t  filters;     ///< How many run, 1 to tables.sets.
    uint8_t  believed;    ///< Which of them learns the shape of the pulses, below `filters`; the caller's to change between two steps.
    sd_kalman_filter_t filter[SD_KALMAN_SETS_MAX]; ///< Filter i runs with set i of gains.
} sd_kalman_t;

/// Whether every field is in its range; false for NaN.
bool sd_kalman_choice_ok(const sd_kalman_choice_t *choice);

/// SD_OK, or SD_ERR_CONFIG with the state untouched: a field of *tables or *choice is outside its range, or there are not
/// so many sets of gains. Starts not running.
sd_result_t sd_kalman_init(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_choice_t *choice, uint8_t filters);

/// The next step begins anew from its own speed, with zero torque.
void sd_kalman_restart(sd_kalman_t *self);

/// Takes a tooth. Returns bit i set when it completed a firing of filter i, and fills firing[i] then; `firing` has room for as
/// many as filters run. A tooth out of range changes nothing.
uint32_t sd_kalman_step(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_tooth_t *tooth, sd_firing_t *firing);

/// The free estimate begins anew as the believed filter has it now, with no lateness at the last tooth.
void sd_kalman_set_free(sd_kalman_t *self);

/// Torque of the engine at tooth `cycle_position`, [0, 2 N), which is that of the last step, as filter `which` has it, Nm, with what a
/// dual-mass flywheel's spring takes away.
float sd_kalman_torque(const sd_kalman_t *self, const sd_kalman_tables_t *tables, uint32_t which, uint32_t cycle_position);

/// Why filter `which` is not valid, sd_why_t bits.
static inline uint32_t sd_kalman_why(const sd_kalman_t *self, uint32_t which) {
    const sd_kalman_filter_t *f = &self->filter[which];
    if ((f->running == 0u) || (f->teeth < self->choice.settle_teeth)) {
        const bool rejected = (f->running != 0u) && ((f->rejected_in_row > 0u) || (self->charge.held != 0u));
        return (uint32_t)SD_WHY_CONVERGING | (rejected ? (uint32_t)SD_WHY_REJECTED : 0u);
    }
    return ((f->rejected_in_row > 0u) || (self->charge.held != 0u)) ? (uint32_t)SD_WHY_REJECTED : 0u;
}

/// sd_health_t of filter `which`: invalid while not running, degraded until settled.
static inline uint8_t sd_kalman_health(const sd_kalman_t *self, uint32_t which) {
    return (uint8_t)((self->filter[which].running == 0u) ? SD_INVALID : (sd_kalman_why(self, which) != 0u) ? SD_DEGRADED : SD_VALID);
}

/// All of it: innovation in rad; test_ratio against the limit as it stands, 0 while not running. It divides and takes a root.
sd_status_t sd_kalman_status(const sd_kalman_t *self, const sd_kalman_tables_t *tables, uint32_t which);

#ifdef __cplusplus
}
#endif

#endif
