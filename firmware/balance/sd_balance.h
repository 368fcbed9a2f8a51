/* SPDX-License-Identifier: MIT */
/// sd_balance.h - fuel trims that make all cylinders alike, from what each deviates from their mean: its lambda or its
/// torque, over the mean.
///
/// Once a cycle, a PI law for each cylinder as for document 004, Figure 16, its step limited, its value limited:
///     trim_i -= clamp(g deviation_i + P (deviation_i - last deviation_i), rate);  trims less their mean;  clamp(trim_i, limit)
/// With P 0, the default, it is a pure integrator.
/// g = gain (0.5 + 0.5 w), w the share of the deviations' mean square, smoothed over 4 cycles, that their stated variance
/// does not explain: fast while there is something to do, quiet when there is only noise. The clamp is the anti-windup: a
/// trim at its limit leaves it with the first deviation of the other sign. Trims hold while the estimate is not valid, its
/// stated standard deviation is above sd_max, or the caller says transient, and for hold_cycles after.
///
/// A loop whose phase is wrong is caught by its watch (sd_balance_watch.h), from how the estimate answers to the trims and
/// not from how far it has run away: the status is invalid until sd_balance_restart, and trims go back to 0 with the rate.
///
/// Once a cycle sd_balance_begin takes the estimate, and sd_balance_work, called once a tooth while it returns true, does the
/// rest piece by piece; trims change with the last one. Float only. Real-time contract: no heap, no globals, no libm; a piece
/// is some passes over the cylinders. One writer per state.
#ifndef SD_BALANCE_H
#define SD_BALANCE_H
#include "sd_balance_watch.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Read by init only.
typedef struct sd_balance_config {
    uint8_t  cylinders;    ///< 2 to SD_BALANCE_CYLINDERS_MAX.
    float    gain;         ///< Of the deviation, a cycle, (0, 1].
    float    proportional; ///< P, [0, 1].
    float    rate;         ///< Largest change of a trim in a cycle, before the mean of all is taken off, (0, 1].
    float    limit;        ///< Largest |trim|, (0, 0.5].
    float    sd_max;       ///< Of a deviation, above which nothing is learned, (0, 1].
    uint16_t hold_cycles;  ///< After a transient or an invalid estimate, any number.
} sd_balance_config_t;

/// What is known of the cylinders at the end of a cycle, by firing order.
typedef struct sd_balance_input {
    const float *deviation, *sd; ///< Of every cylinder's torque or lambda, as a share of the mean; its standard deviation, the same.
    float   follow;              ///< Share of a change that the estimate takes up in a cycle, (0, 1].
    uint8_t told;                ///< The estimate knows of the trims as they are now (sd_afr.h); 0: it follows them.
    uint8_t health;              ///< Of the estimate.
    uint8_t transient;           ///< Speed or fuel moves.
} sd_balance_input_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_balance {
    sd_balance_config_t config;
    sd_watch_t watch;
    float    trim[SD_BALANCE_CYLINDERS_MAX]; ///< Fuel factor less 1.
    float    mean_square, noise;             ///< Of the deviations, smoothed; of their stated variance.
    uint32_t learned;                        ///< Cycles since restart in which trims moved.
    float    deviation[SD_BALANCE_CYLINDERS_MAX]; ///< Of the cycle at work, share of the mean.
    float    last[SD_BALANCE_CYLINDERS_MAX];      ///< Of the last cycle that moved the trims, share of the mean.
    uint8_t  has_last;                       ///< 1: `last` is there.
    uint16_t hold;                           ///< Cycles left on hold.
    uint8_t  diverged, at_limit;             ///< 1: the phase is wrong; a trim is at config.limit.
    uint8_t  at_work;                        ///< What sd_balance_work does next, 0: nothing.
} sd_balance_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched. Trims are 0.
sd_result_t sd_balance_init(sd_balance_t *self, const sd_balance_config_t *config);
/// Other choices from the next cycle on. SD_OK, or SD_ERR_CONFIG with the state untouched. Trims stay, within the new limit.
sd_result_t sd_balance_configure(sd_balance_t *self, const sd_balance_config_t *config);
/// Switched off: trims to 0, everything forgotten.
void sd_balance_restart(sd_balance_t *self);
/// The estimate was mended: the watch begins anew, and trims go on from where they are after a hold.
void sd_balance_resume(sd_balance_t *self);
/// A cycle has ended. A number that is not finite counts as an invalid estimate. What was left of the last one is left out.
void sd_balance_begin(sd_balance_t *self, const sd_balance_input_t *input);
/// The next piece of that. True while more is left: call it again with the next tooth.
bool sd_balance_work(sd_balance_t *self);
/// Valid while learning; degraded on hold or at a limit; invalid when the phase is wrong.
sd_status_t sd_balance_status(const sd_balance_t *self);

#ifdef __cplusplus
}
#endif

#endif
