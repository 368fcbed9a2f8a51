/* SPDX-License-Identifier: MIT */
/// sd_afr_delay.h - does the gas reach the lambda sensor when the model says, and is the sensor as slow as it says? From how
/// the sensor answers to fuel trims, which are known.
///
/// What cylinders differ by and a delay look alike: a pattern turned by m d over the cylinders (order m, delay off by d) is
/// another pattern. Trims break that. Beside the filter runs a model of its own (x, s2, s1 of sd_afr_joint.h) whose cylinders
/// hold the trims and nothing else. Once a cycle the half order of both is taken over the same samples (between them the last one stands),
///     Y = sum of (y - level) exp(-j phi),  P = sum of s1 exp(-j phi),   phi once around in a cycle
/// and over cycles Y = R P + constant is fitted, some 400 of them at most: what injectors differ by is in the constant.
/// With a delay believed too long by d (crank angle) arg R = d/2, unambiguous to +-360 deg; with lags tau (1 + e) it turns by
/// -B e more and shrinks, ln|R| = -A e, where A = sum of (w tau)^2/(1 + (w tau)^2), B = sum of w tau/(1 + (w tau)^2) over both
/// lags and w is half the crank's speed. The residual of the fit gives the deviation of all. The first order would say the
/// same, but a usual sensor passes six times less of it.
///
/// Passive: the trims are those of the balance. They oppose the deviations, so a step of an injector makes |R| small and
/// leaves its angle; hence only the delay is learned from them. An injector that moves while the trims rest moves the constant: cycles
/// that neither the fit nor an answer to the trims explains begin it anew. Active: a probe, a trim of its own on the first cylinder in
/// firing order, less its mean, that changes sign every few cycles and is taken back. Cycles after a step of the trims do not
/// count, since the mean has not settled.
///
/// What was learned is kept with its deviation: each fit is weighed against it, and what was learned grows old with each.
/// It can be stored while the engine is off (sd_afr_kept_t), as it is on the engine, whatever the calibration of the next start
/// says. Meanwhile the sensor may have been changed, or what was learned was wrong: until a fit has borne it out, one that
/// contradicts it by more than 2.5 of its deviations counts as if nothing had been known.
///
/// Float only. Real-time contract: no heap, no globals, no libm; a step costs some 40 flop, cycle divides. Call order: init;
/// step for every wheel position, missing ones included; cycle once a cycle. One writer per state.
#ifndef SD_AFR_DELAY_H
#define SD_AFR_DELAY_H
#include "sd_afr_inflow.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Read by init only.
typedef struct sd_afr_delay_config {
    uint16_t cycle_positions; ///< 24 to SD_AFR_POSITIONS_MAX.
    uint8_t  cylinders;       ///< 2 to SD_AFR_CYLINDERS_MAX.
    float    tau1_s, tau2_s;  ///< The sensor's lags as calibrated, each [1e-4, 1].
} sd_afr_delay_config_t;

/// What is known.
typedef struct sd_afr_learned {
    float late_s, late_sd_s;  ///< How much later than calibrated the gas is at the sensor, and its standard deviation.
    float lag, lag_sd;        ///< By what share the lags are longer than calibrated.
} sd_afr_learned_t;

/// What is stored while the engine is off: what was learned, and the calibration that it is relative to.
typedef struct sd_afr_kept {
    sd_afr_learned_t learned;
    float dead_s;             ///< Dead time to the sensor as it was calibrated then.
    float tau1_s, tau2_s;     ///< The sensor's lags as calibrated then. All three 0: nothing was stored.
} sd_afr_kept_t;

/// What is known at the end of a cycle.
typedef struct sd_afr_trims {
    float        speed_radps; ///< Mean of the cycle.
    const float *trim;        ///< Of every cylinder's lambda, by firing order, of the gas that arrives from now on.
    float        mean_lambda; ///< Of all cylinders.
    uint8_t      steady;      ///< 0: neither this cycle nor the next count.
} sd_afr_trims_t;

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
/// Lambda and its parts have no unit; Y, P, y and s1 are those of the head of this file.
typedef struct sd_afr_delay {
    sd_afr_delay_config_t config;
    sd_afr_learned_t learned;
    float    turn[2], phase[2];                  ///< Cosine and sine: of the half order over a position; over the cycle so far.
    float    trim[SD_AFR_CYLINDERS_MAX];         ///< As above, times the mean lambda.
    float    x, lag2, lag1, move2, move1;        ///< The model: air fraction, its two lags, and what share each moves in a position.
    float    seen[2], told[2];                   ///< Y and P of the cycle so far: cosine and sine parts, air fraction.
    float    sum, level;                         ///< Sum of this cycle's samples; mean of the last cycle's. Air fraction.
    float    last_seen, last_told;               ///< y and s1 at the last sample, air fraction: they stand where there is none.
    uint16_t samples, last_samples;              ///< In this cycle so far; in the last one.
    uint16_t settles, skip;                      ///< Cycles that do not count after a step, and how many are left of them.
    float    usual_seen[2], usual_told[2];       ///< Means of Y and P over cycles, air fraction.
    float    seen_square, told_square, cross[2]; ///< Sums of |Y|^2, |P|^2, Y P*, less their means.
    float    off[2];                             ///< Mean of what the fit leaves of Y in the last few cycles, air fraction.
    uint16_t cycles;                             ///< Cycles in the sums and means above.
    uint16_t probed;                             ///< Cycles of the probe so far, 0: none.
    uint8_t  set;                                ///< 1: a step of the positions has been set.
    uint8_t  unproven;                           ///< 1: `learned` is of an earlier start, and no fit has borne it out.
} sd_afr_delay_t;

/// What an error of the model leaves: the error's mean square over that of the cylinders' deviations, at the half order.
/// (A^2 + B^2) lag_sd^2 + (speed late_sd_s/2)^2; a balanced engine shows none. tau1_s, tau2_s: the lags.
float sd_afr_delay_doubt(const sd_afr_learned_t *known, float speed_radps, float tau1_s, float tau2_s);
/// SD_OK, or SD_ERR_CONFIG with the state untouched. Nothing is learned yet: late_s 0 +- 10 ms, lag 0 +- 0.2.
sd_result_t sd_afr_delay_init(sd_afr_delay_t *self, const sd_afr_delay_config_t *config);
/// Goes on with what was stored; dead_s: as calibrated now, s. To be called behind init. SD_OK; SD_ERR_CONFIG with the state untouched
/// when a number is not finite, or seen from this calibration the delay is off by more than 50 ms or the lags by more than half.
sd_result_t sd_afr_delay_resume(sd_afr_delay_t *self, float dead_s, const sd_afr_kept_t *kept);
/// What to store; dead_s: as calibrated now, s.
void sd_afr_delay_keep(const sd_afr_delay_t *self, float dead_s, sd_afr_kept_t *kept);
/// The angle was lost: fits begin anew, what was learned stays.
void sd_afr_delay_restart(sd_afr_delay_t *self);
/// Next position, as the joint filter is given it. measured: air fraction, (-2, 2), anything else (NaN too) is no sample.
void sd_afr_delay_step(sd_afr_delay_t *self, const sd_afr_inflow_t *in, uint32_t cycle_position, float measured);
/// Ends a cycle. Returns true when something was learned: the caller then takes `learned` over into what `in` comes from.
/// Numbers that are not finite count as not steady.
bool sd_afr_delay_cycle(sd_afr_delay_t *self, const sd_afr_trims_t *cycle);
/// Begins a probe, or ends it. It ends by itself when the fit is good for 5 deg crank, or after 600 cycles.
void sd_afr_delay_probe(sd_afr_delay_t *self, bool on);
/// The probe's part of a cylinder's trim, in units of its size: 1 or -1 for the first, the others make the sum 0. 0 without.
float sd_afr_delay_probe_trim(const sd_afr_delay_t *self, uint32_t cylinder);

#ifdef __cplusplus
}
#endif

#endif
