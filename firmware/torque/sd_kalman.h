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
/// torque's share of the gain K_s says of it. One tooth position, d the pitch (derivation: docs/firing.md):
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
/// it beside the first, and sd_road.h chooses.
///
/// Firing torque: x_j as it stands read_position of firing j, a good half turn after its pulse.
///
/// Real-time contract: no heap, no globals, no libm; a step costs 9 m + 4 n + 60 flop and one division a present tooth for m
/// coefficients and n cylinders (4 cylinders: m = 5, 121 flop), 4 m + 4 n + 20 for each missing one, and 100 + 5 n a mode. One writer per state. Tables are
/// read only and may be shared. Call order: init; step for every placed tooth; restart after lost sync or a stall.
#ifndef SD_KALMAN_H
#define SD_KALMAN_H
#include "sd_limits.h"
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_KALMAN_COEFFICIENTS_MAX 25
#define SD_KALMAN_POSITIONS_MAX    120
#define SD_KALMAN_SPEEDS_MAX       12
#define SD_KALMAN_FIRINGS_MAX      SD_CYLINDERS_MAX
#define SD_KALMAN_SETS_MAX         2    ///< Of gains.
#define SD_KALMAN_GAINS_MAX        (SD_KALMAN_SETS_MAX * SD_KALMAN_SPEEDS_MAX)
#define SD_KALMAN_MODES_MAX        2
#ifndef SD_KALMAN_POOL
#define SD_KALMAN_POOL             28000///< Floats for torques and gains: 12 speeds for 8 cylinders with 2 modes. A build for less may define it.
#endif

/// A natural vibration that moves the toothed wheel. Torques in Nm hold it at a twist of the wheel in rad.
typedef struct sd_kalman_mode {
    float frequency_radps;  ///< w_m, [1, 1e5].
    float damping;          ///< z, share of critical, [0, 1).
    float constant_radpnm;  ///< Compliance to x_0.
    float cylinder_radpnm[SD_KALMAN_FIRINGS_MAX]; ///< Compliance to each cylinder's torque.
    float spring_nmprad, damper_nmprad; ///< Torque that leaves the crank through a flywheel's spring, for q and for v.
} sd_kalman_mode_t;

/// Read only. One row of `pool` a cycle position k, angles between the teeth k - 1 and k:
/// mean[m - 1], moment[m - 1], point[m - 1] of the basis; mean[n], moment[n], point[n] of each cylinder's motored torque,
/// Nm per bar of its intake pressure; with a shape to learn, mean[n], moment[n], point[n] of g; for each mode the twist that its mean known torques hold: rad, and rad a w^2 of
/// (rad/s)^2; then for each speed of each set K_0, K_1, K_x[m], K_s with a shape, and K_q, K_v of each mode.
/// mean: over the interval; moment: of (1 - s) f, s from 0 to 1 over the interval; point: at tooth k.
typedef struct sd_kalman_tables {
    uint8_t  positions;    ///< Wheel positions a revolution N, even, 12 to 120.
    uint8_t  coefficients; ///< m, 1 to SD_KALMAN_COEFFICIENTS_MAX, x_0 included.
    uint8_t  speeds;       ///< Gain tables of a set, 1 to SD_KALMAN_SPEEDS_MAX.
    uint8_t  sets;         ///< 1: for smooth roads; 2: for rough ones too.
    uint8_t  firings;      ///< Coefficient 1 + i belongs to firing i; 0 with the Fourier basis. Below m.
    uint8_t  cylinders;    ///< n, 1 to SD_KALMAN_FIRINGS_MAX, in firing order.
    uint8_t  modes;        ///< Up to SD_KALMAN_MODES_MAX; 0 with the Fourier basis.
    uint8_t  shapes;       ///< 1: the pulses have a shape to learn; 0: none, as with the Fourier basis.
    uint16_t read_position[SD_KALMAN_FIRINGS_MAX];  ///< Cycle position at which firing i is read, [0, 2 N).
    uint16_t close_position[SD_KALMAN_FIRINGS_MAX]; ///< Cycle position at which cylinder i's intake valve closes, [0, 2 N).
    float    tick_hz;        ///< Capture ticks a second, [1e5, 2e8].
    float    shape_min_nm;   ///< Mean torque of all cylinders below which the shape is not learned, [0, 20000].
    float    inertia_mean_kgm2;                             ///< (0, 10].
    float    inertia_tooth_kgm2[SD_KALMAN_POSITIONS_MAX];   ///< At position k, (0, 10].
    float    inertia_interval_kgm2[SD_KALMAN_POSITIONS_MAX];///< J_interval: what takes as long as J(alpha) does, (0, 10].
    float    known[3][2 * SD_KALMAN_POSITIONS_MAX];         ///< Motored torque beside what scales with intake pressure, Nm: mean, moment, point.
    sd_kalman_mode_t mode[SD_KALMAN_MODES_MAX];
    float    speed_radps[SD_KALMAN_SPEEDS_MAX];             ///< Of the gain tables, ascending, > 0.
    /// Of each speed of each set: the timing error that the gains were made for, > 0, and the expected rms of the
    /// innovation over that, >= 1.
    float    noise_rad[SD_KALMAN_GAINS_MAX], innovation[SD_KALMAN_GAINS_MAX];
    /// Standard deviation of a firing less the mean of all cylinders, per rad of timing error, over J_mean w^2: one
    /// firing, errors new at each edge; mean of SD_KALMAN_MEAN cycles, the same; either, errors that stay with a tooth.
    float    single_sd[SD_KALMAN_GAINS_MAX], mean_sd[SD_KALMAN_GAINS_MAX], pattern_sd[SD_KALMAN_GAINS_MAX];
    float    load_sd_nm[SD_KALMAN_GAINS_MAX]; ///< Of a firing, from the load's walk that the gains were made for, >= 0.
    /// Standard deviation of a firing less the mean of all cylinders from what is not known of the engine: share of the mean torque, share
    /// of the cylinders' rms difference from it, and Nm per bar of charge: before and after the cylinder's zero was learned.
    float    mean_share[SD_KALMAN_GAINS_MAX], spread_share[SD_KALMAN_GAINS_MAX];
    float    charge_nm_per_bar[SD_KALMAN_GAINS_MAX], learned_nm_per_bar[SD_KALMAN_GAINS_MAX];
    float    pool[SD_KALMAN_POOL];
} sd_kalman_tables_t;

#define SD_KALMAN_SHAPE_MIN (-1.0f)
#define SD_KALMAN_SHAPE_MAX 3.0f
#define SD_KALMAN_MEAN 10 ///< Cycles that a cylinder's mean torque is taken over.

/// What may change while the filter runs, and needs no restart then. It stands in the state, because tables are constant.
typedef struct sd_kalman_choice {
    float    torque_base_nm; ///< Highest |coefficient|, [1e-3, 20000]; beyond it the filter starts anew.
    float    reject_rad;     ///< Lateness beyond which a tooth is left out, besides what a torque explains, [1e-6, 1]; once
                             ///< settled it is 8 times the innovation as met.
    uint16_t settle_teeth;   ///< Teeth until the estimate counts as converged.
} sd_kalman_choice_t;

/// A placed tooth.
typedef struct sd_kalman_tooth {
    uint16_t cycle_position; ///< [0, 2 N).
    uint16_t advance;        ///< Positions since the last one, 1 to 2 N.
    uint32_t period_ticks;   ///< Time since the last one.
    uint8_t  trusted;        ///< 0: predict only.
    float    late_rad;       ///< Learned error of this tooth, positive when its edge comes late.
    float    pattern_rad;    ///< Standard deviation of what is not learned of it.
    float    intake_bar;     ///< Intake pressure, [0, 10]; anything else, NaN included: the last good one is held.
} sd_kalman_tooth_t;

/// One firing: sent when its estimate is complete.
typedef struct sd_firing {
    uint8_t index;      ///< In firing order.
    float   raw_nm;     ///< torque_nm before zero_nm_per_bar was taken out.
    float   torque_nm;  ///< Mean combustion torque over the 180 deg after its TDC.
    float   sd_nm;      ///< Standard deviation of that less the mean of all cylinders: timing noise as met, what is not
                        ///< known of the engine, and with the gains for rough roads what the load's walk gives.
    float   noise_nm;   ///< From timing errors that are new at each edge: as met, and no less than the gains were made for.
    float   mean_nm;    ///< Of this cylinder's last SD_KALMAN_MEAN cycles, fewer after a start.
    float   mean_sd_nm;
} sd_firing_t;

/// What was learned of the crank's modes (sd_twist.h): how much faster they swing than in the tables. To the gains a mode
/// of r times the frequency at r times the speed is what it was, so they are looked up at 1 / r of the speed.
typedef struct sd_kalman_tuning {
    float frequency;  ///< r, [0.9, 1.1],
    float gain_speed; ///< 1 / r,
    float compliance; ///< 1 / r^2: the twist that a torque holds, over that of the tables.
} sd_kalman_tuning_t;

typedef struct sd_kalman {
    float    lateness_s;  ///< When the last tooth was due, after it came.
    float    energy_j;    ///< At the last tooth.
    float    coefficient_nm[SD_KALMAN_COEFFICIENTS_MAX];
    float    torque_nm;   ///< T at the last tooth.
    float    intake_bar;  ///< Last good one,
    float    charge_bar[SD_KALMAN_FIRINGS_MAX]; ///< and as it was when each cylinder's intake valve closed.
    float    twist_rad[SD_KALMAN_MODES_MAX];    ///< q and v of each mode.
    float    swing_rad[SD_KALMAN_MODES_MAX];
    float    innovation_rad, test_ratio;
    float    noise_ratio; ///< Running mean square of the innovation over its expectation.
    float    shape;       ///< [SD_KALMAN_SHAPE_MIN, SD_KALMAN_SHAPE_MAX], kept by restart.
    float    zero_nm_per_bar[SD_KALMAN_FIRINGS_MAX]; ///< What a cylinder reads without combustion, of its charge; 0: not learned; kept by restart.
    sd_kalman_tuning_t tuning; ///< Kept by restart.
    sd_kalman_choice_t choice; ///< Kept by restart; may be changed between two steps to another that sd_kalman_choice_ok takes.
    float    ring_nm[SD_KALMAN_FIRINGS_MAX][SD_KALMAN_MEAN];
    uint8_t  kept[SD_KALMAN_FIRINGS_MAX]; ///< Filled places of each ring.
    uint8_t  next[SD_KALMAN_FIRINGS_MAX]; ///< Where the next firing goes.
    uint16_t teeth;       ///< Since restart, saturating.
    uint16_t rejected, rejected_in_row;
    uint8_t  running;
    uint8_t  intake_held; ///< The last intake pressure was no number in range.
    uint8_t  set;         ///< Of gains, below tables.sets; 0 after init, the caller's to change between two steps.
} sd_kalman_t;

/// Whether every field is in its range; false for NaN.
bool sd_kalman_choice_ok(const sd_kalman_choice_t *choice);

/// Whether every field is in its range, so that init takes them.
bool sd_kalman_tables_ok(const sd_kalman_tables_t *tables);

/// Floats of `pool` that such tables use.
uint32_t sd_kalman_pool_used(const sd_kalman_tables_t *tables);

/// SD_OK, or SD_ERR_CONFIG with the state untouched: a field of *tables or *choice is outside its range. Starts not running.
sd_result_t sd_kalman_init(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_choice_t *choice);

/// The next step begins anew from its own speed, with zero torque.
void sd_kalman_restart(sd_kalman_t *self);

/// Takes a tooth. Returns true when it completed a firing, and fills *firing then. A tooth out of range changes nothing.
bool sd_kalman_step(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_tooth_t *tooth,
                    sd_firing_t *firing);

/// Lateness of the last tooth against the prediction, rad, its own error not taken out.
float sd_kalman_late(const sd_kalman_t *self, const sd_kalman_tables_t *tables, uint32_t cycle_position);

/// Mean torque over the interval that ends at a cycle position, as the filter has it.
float sd_kalman_torque(const sd_kalman_t *self, const sd_kalman_tables_t *tables, uint32_t cycle_position);

/// Whether the wheel has a tooth at a position: where it has none, gains are zero.
bool sd_kalman_has_tooth(const sd_kalman_tables_t *tables, uint32_t position);

/// Takes this for the intake pressure of every cylinder.
void sd_kalman_set_intake(sd_kalman_t *self, float intake_bar);

/// innovation in rad; health invalid while not running, degraded until settled.
sd_status_t sd_kalman_status(const sd_kalman_t *self);

#ifdef __cplusplus
}
#endif

#endif
