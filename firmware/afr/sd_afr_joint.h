/* SPDX-License-Identifier: MIT */
/// sd_afr_joint.h - composition of every cylinder's gas from the wideband sensor, in one periodic Kalman filter: ours,
/// in place of blocks A and D of document 004 (docs/theory/afr.md).
///
/// State: x air fraction in the manifold as it reaches the sensor, a_i of every cylinder's gas, s2 and s1 the two lags of
/// the sensor. Once a wheel position, with M and D_i as the sensor meets them (sd_afr_inflow.h, delay included):
///     x   = (M x + sum D_i a_i)/(M + sum D_i)     D_i >= 0: stable whatever the numbers
///     s2 += m2 (x - s2);  s1 += m1 (s2 - s1)      m = 1 - exp(-step/tau)
/// and every third position (at high speed every sixth, see set), with the mean error e = y - s1 of the samples in the group:
///     state += K e
/// K is either given (fixed gains, one column a position, and a correction at each) or found on the way from the filter's own
/// covariance, which moves by as many positions at a time: the lags follow the x before them, and what a cylinder lets in within
/// them is mixed in at once. The sensor's lags are tens of positions, so this K is as good as one found at every position
/// (docs/theory/afr.md). Each line above touches one row of the covariance. a_i gains variance q^2 once a cycle, where its
/// exhaust begins. Where innovations keep to one side
/// by more than 5 of their standard deviations, every state gains jump^2: a small drift for quiet estimates and yet a step
/// is followed as fast as the noise allows. Covariance comes with what the estimate may be trusted for: sd of a cylinder's
/// deviation from the mean.
///
/// Float only. Real-time contract: no heap, no globals, no libm; set divides, once a cycle. One writer per state.
#ifndef SD_AFR_JOINT_H
#define SD_AFR_JOINT_H
#include "sd_afr_inflow.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AFR_GROUP 3 /* positions whose samples are taken in together; twice as many at high speed, see set */

/// Read by init only.
typedef struct sd_afr_joint_config {
    uint8_t  cylinders;         ///< 1 to SD_AFR_CYLINDERS_MAX.
    uint16_t cycle_positions;   ///< Of two revolutions, 24 to SD_AFR_POSITIONS_MAX.
    float    tau1_s, tau2_s;    ///< The sensor's lags, each [1e-4, 1].
    float    noise_per_rthz;    ///< One-sided density of the sensor's noise, of lambda, (0, 0.1].
    float    drift;             ///< q: how far a cylinder may move in one cycle, of lambda, (0, 1].
    float    start_sd;          ///< Of a_i at a start, (0, 1].
    float    reject;            ///< Innovations beyond this many of their sd are left out, [3, 1e3].
} sd_afr_joint_config_t;

/// Its parts; symmetric; the square of an air fraction each. Rows of cylinders are filled up with zeros to a multiple of four.
typedef struct sd_afr_covariance {
    float a[SD_AFR_CYLINDERS_MAX][SD_AFR_CYLINDERS_MAX]; ///< Covariance of a_i with a_j, both halves.
    float x_a[SD_AFR_CYLINDERS_MAX], s2_a[SD_AFR_CYLINDERS_MAX], s1_a[SD_AFR_CYLINDERS_MAX]; ///< Covariance of x, s2 and s1 with a_i.
    float x_x, s2_x, s1_x, s2_s2, s1_s2, s1_s1;          ///< Covariance of x, s2 and s1 with one another.
} sd_afr_covariance_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_afr_joint {
    float x, air_fraction[SD_AFR_CYLINDERS_MAX], lag2, lag1; ///< The estimate x, a_i, s2, s1: air fraction.
    sd_afr_covariance_t p;
    float move2, move1;         ///< m2 and m1 of a position: the share that each lag moves.
    float group2, group1;       ///< m2 and m1 of a group, the same.
    float pace, mean_max;       ///< Of the mean innovation: its move in a group, and its square, over an innovation's, that is a jump.
    float noise_var, drift_var, jump_var; ///< Variance of a sample's noise, of a cycle's drift, of a jump: air fraction squared.
    float innovation, test_ratio; ///< e of the last group, air fraction; its square over the expected one, as in sd_status_t.
    sd_afr_joint_config_t config;
    float mean_innovation;      ///< Of the last 16 samples or so, in standard deviations.
    float error;                ///< Sum of y - s1 over the samples of the group so far.
    float keep;                 ///< Share of x that is still there from before the group.
    float let_in[SD_AFR_CYLINDERS_MAX]; ///< What has come from each cylinder in the group, over `keep`.
    uint16_t rejected, rejected_in_row; ///< Groups left out since the start; positions of those left out in a row.
    uint16_t jumps, hold;       ///< How many there were; positions until the next may be seen.
    uint8_t  running;           ///< 1: the estimate follows the samples.
    uint8_t  group;             ///< Positions of a group.
    uint8_t  positions, samples; ///< Of the group so far.
    uint8_t  flowing;           ///< Bit i: the cylinder's gas passed in the last group.
} sd_afr_joint_t;

/// What is known of the cylinders beside the one to blame.
typedef struct sd_afr_usual {
    float sd;        ///< How they differ anyway, of lambda, [1e-6, 1].
    float lambda;    ///< What all have in common: their lambda before the fault, say, [-2, 2].
    float lambda_sd; ///< How far that may have moved since, [1e-6, 1]; anything else: it is not known.
} sd_afr_usual_t;

/// The cylinder that explains best what is wrong.
typedef struct sd_afr_blame {
    uint32_t cylinder;  ///< By firing order.
    float    deviation; ///< By how much of lambda it is off.
    float    explained; ///< Of the weighted square of what cylinders are off by: twice the gain in log likelihood.
} sd_afr_blame_t;

/// SD_OK if init takes it, else SD_ERR_CONFIG.
sd_result_t sd_afr_joint_check(const sd_afr_joint_config_t *config);
/// SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_afr_joint_init(sd_afr_joint_t *self, const sd_afr_joint_config_t *config);
/// Duration of a position, (0, 0.1] s; drift in place of the configured one, (0, 1]; jump, [0, 1] of lambda, 0 for none.
/// Ignored outside. Below 0.3 ms a group has 2 SD_AFR_GROUP positions, where the sensor's lags last 150 positions at least and two
/// such groups fit between firings.
void sd_afr_joint_set(sd_afr_joint_t *self, float step_s, float drift, float jump);
/// The next sample begins anew, all cylinders alike.
void sd_afr_joint_restart(sd_afr_joint_t *self);
/// Next position. measured: air fraction, mean of the samples within the position, (-2, 2); anything else (NaN too)
/// counts as no sample. gains: NULL, or K of this position in the order x, a_i, s2, s1 (the covariance then rests).
void sd_afr_joint_step(sd_afr_joint_t *self, const sd_afr_inflow_t *in, float measured, const float *gains);
/// A cylinder's lambda is known to have changed by this much: its fuel was trimmed. Ignored beyond +-1 (NaN too).
void sd_afr_joint_move(sd_afr_joint_t *self, uint32_t cylinder, float lambda_change);
/// lambda = 1 - a of a cylinder, by firing order; 0 beyond, or while not running.
float sd_afr_joint_lambda(const sd_afr_joint_t *self, uint32_t cylinder);
/// Variance of each cylinder's lambda minus the mean of all, by firing order: [cylinders].
void sd_afr_joint_deviation_variances(const sd_afr_joint_t *self, float *variance);
/// The cylinder that being rich or lean alone explains best how the cylinders are, weighing what the samples tell apart well.
/// One that is rich and the one opposite in the firing order that is lean look nearly alike to a slow sensor; what tells them
/// apart is which way the mean of all moved, hence usual->lambda. Once a cycle: it inverts a matrix of all cylinders. All 0
/// while not running, with fewer than two cylinders, or sd outside its range.
sd_afr_blame_t sd_afr_joint_blame(const sd_afr_joint_t *self, const sd_afr_usual_t *usual);
/// Entry of the covariance, air fraction squared, states in the order x, a_i, s2, s1; 0 beyond.
float sd_afr_joint_covariance(const sd_afr_joint_t *self, uint32_t row, uint32_t column);
/// Invalid until the first sample; rejected samples degrade it.
sd_status_t sd_afr_joint_status(const sd_afr_joint_t *self);

#ifdef __cplusplus
}
#endif

#endif
