/* SPDX-License-Identifier: MIT */
/// sd_balance.h - fuel trims that make all cylinders alike, from what each deviates from their mean: its lambda or its
/// torque, over the mean.
///
/// Once a cycle, a pure integrator for each cylinder, its step limited, its value limited:
///     trim_i -= clamp(gain deviation_i, rate);  trims less their mean;  clamp(trim_i, limit)
/// The clamp is the anti-windup: a trim at its limit leaves it with the first deviation of the other sign. Trims hold
/// while the estimate is not valid, its stated standard deviation is above sd_max, or the caller says transient, and for
/// hold_cycles after. A loop that drives deviations up instead of down (wrong phase) is caught by their rms, smoothed over
/// some 4 cycles: when its square stays above 4 times its least since the loop closed plus 4 times the stated variance for
/// 3/gain cycles, trims go back to 0 and the status is invalid until sd_balance_restart. A step of an injector is worn
/// down sooner than that.
///
/// Float only. Real-time contract: no heap, no globals, no libm; some passes over the cylinders. One writer per state.
#ifndef SD_BALANCE_H
#define SD_BALANCE_H
#include "sd_num.h"
#include "sd_status.h"

#define SD_BALANCE_CYLINDERS_MAX 8

/// Read by init only.
typedef struct sd_balance_config {
    uint8_t  cylinders;    ///< 2 to SD_BALANCE_CYLINDERS_MAX.
    float    gain;         ///< Of the deviation, a cycle, (0, 1].
    float    rate;         ///< Largest change of a trim in a cycle, before the mean of all is taken off, (0, 1].
    float    limit;        ///< Largest |trim|, (0, 0.5].
    float    sd_max;       ///< Of a deviation, above which nothing is learned, (0, 1].
    uint16_t hold_cycles;  ///< After a transient or an invalid estimate.
} sd_balance_config_t;

typedef struct sd_balance {
    sd_balance_config_t config;
    float    trim[SD_BALANCE_CYLINDERS_MAX]; ///< Fuel factor less 1.
    float    mean_square, least, noise;      ///< Of the deviations, smoothed; its least; of their stated variance.
    uint32_t learned;                        ///< Cycles since restart in which trims moved.
    uint16_t hold, grown;                    ///< Cycles left on hold; since deviations are too large.
    uint8_t  diverged, at_limit;
} sd_balance_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched. Trims are 0.
sd_result_t sd_balance_init(sd_balance_t *self, const sd_balance_config_t *config);
/// Other choices from the next cycle on. SD_OK, or SD_ERR_CONFIG with the state untouched. Trims stay, within the new limit.
sd_result_t sd_balance_configure(sd_balance_t *self, const sd_balance_config_t *config);
/// Switched off: trims to 0, everything forgotten.
void sd_balance_restart(sd_balance_t *self);
/// One cycle. deviation and sd of each cylinder (any order, kept by the caller), health of the estimate, transient: speed
/// or fuel moves. A number that is not finite counts as an invalid estimate.
void sd_balance_step(sd_balance_t *self, const float *deviation, const float *sd, uint8_t health, uint8_t transient);
/// Valid while learning; degraded on hold or at a limit; invalid when diverged.
sd_status_t sd_balance_status(const sd_balance_t *self);

#endif
