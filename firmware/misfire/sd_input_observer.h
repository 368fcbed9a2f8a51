/* SPDX-License-Identifier: MIT */
/// sd_input_observer.h - the crank of document 000 with an unknown strength E_n of every cylinder: a Kalman filter.
///
///   v1' = v2,  v2' = -k2 v2 - k1 v1 + sum over n of E_n (C Q_n),  E_n a random walk,  y = v1 + noise
/// The document's observers take the nominal input, so a misfire that nobody told them of stays in their estimate
/// forever. Here E_n is a state: 1 is a cylinder that does what its input says, 0 a misfire.
///
/// The step is exact (sd_plant_step.h) for the mean input of each cylinder over it. The covariance runs along, in
/// Joseph's form: at a fixed sampling time firings never fall on the same samples twice, so no table of gains would
/// serve, and it gives every estimate its standard deviation. Two innovations in a row beyond `alarm_sd` deviations, on
/// the same side, mean that the active cylinder no longer does what it did: its E is then learned anew, from deviation 1
/// (while its input acts; else v2 is, from start_accel).
///
/// Real-time contract: no heap, no globals, no libm; a step costs about 6 (n + 2)^2 multiplications.
/// One writer per state. Call order: init; start; step for every sample; read.
#ifndef SD_INPUT_OBSERVER_H
#define SD_INPUT_OBSERVER_H
#include "sd_limits.h"
#include "sd_num.h"
#include "sd_plant_step.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_INPUT_CYLINDERS_MAX SD_CYLINDERS_MAX
#define SD_INPUT_STATES_MAX    (SD_INPUT_CYLINDERS_MAX + 2)

/// SI units; read by init only, need not outlive it.
typedef struct sd_input_config {
    const sd_plant_step_t *step; ///< The sampling interval.
    uint8_t  cylinders;          ///< 1 to SD_INPUT_CYLINDERS_MAX.
    float    noise_mps;          ///< Standard deviation of y, (0, 100].
    float    start_speed_mps;    ///< Deviation of v1 at the start, (0, 1e3].
    float    start_accel_mps2;   ///< Deviation of v2 at the start, (0, 1e5].
    float    start_strength;     ///< Deviation of each E_n at the start, (0, 1].
    float    walk_strength;      ///< Deviation of each E_n's walk in one step, [0, 1].
    float    alarm_sd;           ///< [3, 100].
    uint32_t settle_steps;       ///< Steps until the estimate counts as converged: a cycle.
} sd_input_config_t;

typedef struct sd_input_estimate {
    float speed_mps, accel_mps2, accel_sd_mps2;
    float strength[SD_INPUT_CYLINDERS_MAX], strength_sd[SD_INPUT_CYLINDERS_MAX]; ///< E_n and its deviation.
    sd_status_t status; ///< innovation in m/s; test_ratio over alarm_sd deviations; rejected: samples left out.
} sd_input_estimate_t;

/// Plain data, caller-owned.
typedef struct sd_input_observer {
    float    state[SD_INPUT_STATES_MAX];                           ///< v1, v2, E_1 ...
    float    covariance[SD_INPUT_STATES_MAX][SD_INPUT_STATES_MAX]; ///< Symmetric.
    float    innovation, test_ratio;
    uint32_t steps, alarms;      ///< Since start, saturating.
    uint16_t rejected, rejected_in_row;
    uint8_t  running, cylinders;
    int8_t   last_side;          ///< Of the last innovation if it was beyond the limit, else 0.
    uint32_t settle_steps;
    float    increment[2][2], from_input[2];
    float    noise_variance, start_variance[3], walk_variance, alarm_squared;
} sd_input_observer_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched. Starts not running.
sd_result_t sd_input_init(sd_input_observer_t *self, const sd_input_config_t *config);

/// Begins with v1 and v2 as given and strength[cylinders] (NULL: all 1). Not finite: stays not running.
void sd_input_start(sd_input_observer_t *self, float speed_mps, float accel_mps2, const float *strength);

/// One step to sample y. input[cylinders]: mean of C Q_n over it, m/s^3, for E_n = 1. active: whose firing interval it is,
/// 0 to cylinders - 1. Not running: starts at y. y not finite: predicts only; 12 in a row, or an input that is not finite
/// or 1e9 and more: stops running. Returns v2, m/s^2, 0 while not running; never NaN.
float sd_input_step(sd_input_observer_t *self, float y_mps, const float *input_mps3, uint8_t active);

void sd_input_read(const sd_input_observer_t *self, sd_input_estimate_t *estimate);

#ifdef __cplusplus
}
#endif

#endif
