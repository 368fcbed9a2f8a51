/* SPDX-License-Identifier: MIT */
/// sd_afr.h - composition of every cylinder's gas, ready to use: manifold and delay (sd_exhaust.h), and on them the joint
/// filter (sd_afr_joint.h) or document 004's chain (sd_afr_chain.h), at the present operating point of a grid from the
/// calibration.
///
/// Once a cycle sd_afr_cycle notes the operating point of the coming one, and sd_afr_work, called once a tooth while it returns
/// true, makes it (sd_afr_point.h). Once a wheel position, missing ones included, comes the step. The chain runs in f32 or in q31; the
/// joint filter in f32. Tables are read where the caller keeps them, and must be the same in every call. Lambda here is document 004's,
/// 1 - air/gas. Real-time contract: no heap, no globals, no libm; a piece costs no more than a step does, but in q31 where the new
/// point takes effect. One writer per state.
#ifndef SD_AFR_H
#define SD_AFR_H
#include "sd_afr_chain.h"
#include "sd_afr_delay.h"
#include "sd_afr_joint.h"
#include "sd_afr_point.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AFR_NO_SAMPLE 100.0f ///< An air fraction that stands for no sample: far outside (-2, 2).

/// Which estimator stands on manifold and delay.
typedef enum sd_afr_method {
    SD_AFR_JOINT       = 1, ///< Joint filter.
    SD_AFR_OSCILLATORS = 2, ///< Chain, sensor inverted as oscillators with gains of the calibration.
    SD_AFR_FOURIER     = 3, ///< Chain, sensor inverted by the document's law.
} sd_afr_method_t;

/// What is read in place, of the calibration.
typedef struct sd_afr_tables {
    const sd_afr_grid_t *grid;   ///< Of the calibration page; NULL or not present: init refuses it.
    const int32_t *sine_q31;     ///< As in sd_uego.h; NULL for the joint filter.
} sd_afr_tables_t;

/// Choices; read by init only.
typedef struct sd_afr_config {
    uint8_t  method;             ///< sd_afr_method_t.
    uint8_t  fixed_point;        ///< 1: the chain in q31; the joint filter has f32 only.
    uint16_t cycle_positions;    ///< Wheel positions in a cycle, as in sd_exhaust_config_t.
    uint8_t  cylinders;          ///< 1 to SD_AFR_CYLINDERS_MAX.
    uint16_t firing_position[SD_AFR_CYLINDERS_MAX]; ///< Cycle position of each firing TDC, below cycle_positions, by firing order.
    float    noise_per_rthz;     ///< One-sided density of the sensor's noise, of lambda, (0, 0.1].
    float    drift, drift_slow;  ///< q of the joint filter, of the mean lambda a cycle: usually, and in slow mode; each (0, 1].
    float    jump;               ///< Of the joint filter, of the mean lambda, [0, 1].
    float    slow_above;         ///< Slow mode where speed (rad/s) times the sum of the lags is above this, > 0.
    float    gain_air, gain_cylinder;         ///< Gains of the chain, as in sd_afr_chain_config_t.
    float    inversion_gain, inversion_floor; ///< Gain and floor of the inverted sensor, as in sd_uego_config_t.
    float    gain_mass;          ///< Gain L1 of the chain, as in sd_exhaust_config_t.
    float    turbine_drop, turbine_rpm; ///< Share of area and its speed, as in sd_afr_point_config_t.
} sd_afr_config_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_afr {
    sd_afr_config_t    config;
    union {                               /* which one: config.fixed_point */
        sd_afr_point_f32_t point;
        sd_afr_point_q31_t point_q31;
    };
    union {                               /* which one: config.method, config.fixed_point */
        sd_afr_joint_t     joint;
        sd_afr_chain_f32_t chain;
        sd_afr_chain_q31_t chain_q31;
    };
    sd_afr_inflow_t in;                   ///< What came to the sensor at the last position.
    sd_afr_learned_t known;               ///< Of delay and lags, and how well.
    float    doubt;                       ///< What that leaves in deviations: sd_afr_delay_doubt.
    float    mean_lambda;                 ///< Of all cylinders, last cycle.
    float    speed_radps;                 ///< Of the coming point.
    float    egr_share;                   ///< The same, [0, SD_AFR_EGR_MAX].
    uint32_t cycles;                      ///< Since a start.
    float    restless;                    ///< Share of the configured drift that counts now, [1/6, 1].
    uint16_t jumps;                       ///< Of the joint filter, at the last cycle.
    uint8_t  slow;                        ///< Slow mode: settles in tens of seconds; the chain has none and stays degraded.
    uint8_t  placed;                      ///< A point has been set.
} sd_afr_t;

/// Harmonics of the cycle that hold every pattern of so many cylinders.
uint8_t sd_afr_harmonics(uint8_t cylinders);
/// SD_OK, or SD_ERR_CONFIG with the state untouched: no grid, or a field out of its range.
sd_result_t sd_afr_init(sd_afr_t *self, const sd_afr_config_t *config, const sd_afr_tables_t *tables);
/// Ends a cycle: the operating point of the coming one, as sd_afr_point_begin. Recirculated gas is part of every cylinder's lambda, and has
/// burned before: tables are read at (1 - egr_share) of the mean, and so much of a trim shows.
void sd_afr_cycle(sd_afr_t *self, const sd_afr_conditions_t *at);
/// The next piece of that. True while more is left: call it again with the next tooth.
bool sd_afr_work(sd_afr_t *self, const sd_afr_tables_t *tables);
/// From the next point on the delay is longer by late_s and the lags by the share lag (sd_afr_delay.h), +-50 ms and +-0.5;
/// ignored beyond (NaN too). Their standard deviations, at least 0, go into what is stated of deviations.
void sd_afr_correct(sd_afr_t *self, const sd_afr_learned_t *known);
/// Angle lost, or off by a revolution: begins anew.
void sd_afr_restart(sd_afr_t *self);
/// Next wheel position; lambda: mean of its samples, or SD_AFR_NO_SAMPLE; exhaust_bar: the pressure in the manifold likewise, 0: no
/// sample. The chain alone takes it, with gain_mass above 0.
void sd_afr_step(sd_afr_t *self, const sd_afr_tables_t *tables, uint32_t cycle_position, float lambda, float exhaust_bar);
/// A cylinder's fuel was changed by this factor, and its gas is about to arrive.
void sd_afr_trimmed(sd_afr_t *self, uint32_t cylinder, float fuel_factor);
/// What the joint filter takes a cylinder to move by in the coming cycle, of the mean lambda: the configured drift, which sinks to a
/// sixth while nothing is known to move. It is back with a jump, with a trim that moves by more than 0.4 %, with speed or intake pressure
/// that moves by more
/// than 0.5 %, and at a start.
float sd_afr_drift(const sd_afr_t *self);
/// Of a cylinder by firing order; 0 while there is no estimate.
float sd_afr_lambda(const sd_afr_t *self, uint32_t cylinder);
/// All of them in one pass.
void sd_afr_read(const sd_afr_t *self, sd_afr_estimate_t *out);
/// Invalid before a point and a sample; degraded while converging (8 cycles, 200 in slow mode; there the chain always).
sd_status_t sd_afr_status(const sd_afr_t *self);

#ifdef __cplusplus
}
#endif

#endif
