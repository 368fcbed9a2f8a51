/* SPDX-License-Identifier: MIT */
/// sd_balance_watch.h - does an estimate of what cylinders deviate by follow the trims as it should, or is its phase wrong?
///
/// An estimate less the trims (those that it was told of, or has taken up by now) is what the injectors deviate by: the trims
/// must not show in it.
/// With a delay that is wrong they do: a pattern of order m over the n cylinders comes back turned by the angle m d, and
/// (turn - 1) times the trims is left, as late as the estimate is slow. So every cycle is asked which explains it better, a
/// delay off by 2/3 of what the loop stands, or by 4/3 (n = 4: 60 or 120 deg crank; both signs). The log of the ratio of the
/// likelihoods, summed and never below 0, is the evidence; at SD_WATCH_LIMIT the phase is wrong. What changes over more than
/// some 12 cycles is left out of it. A jump that no trim can have caused is a step of an injector: what was before it says
/// nothing of what follows.
///
/// Float only, no heap, no I/O, no libm; some passes over cylinders times patterns. One writer per state.
#ifndef SD_BALANCE_WATCH_H
#define SD_BALANCE_WATCH_H
#include "sd_limits.h"
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_BALANCE_CYLINDERS_MAX SD_CYLINDERS_MAX ///< Cylinders of an engine.
#define SD_WATCH_LIMIT           5.0f ///< Evidence from which the phase counts as wrong, log of a ratio of likelihoods.

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_watch {
    float    turn[3 * SD_BALANCE_CYLINDERS_MAX][2];  ///< exp(j k 120 deg/n): cosine, sine.
    float    shown[SD_BALANCE_CYLINDERS_MAX];        ///< Trims as far as the estimate has taken them up, shares.
    float    usual_injector[SD_BALANCE_CYLINDERS_MAX], usual_shown[SD_BALANCE_CYLINDERS_MAX]; ///< Means of some 12 cycles, shares.
    float    last_injector[SD_BALANCE_CYLINDERS_MAX]; ///< What the injectors deviated by in the last cycle, share.
    float    evidence[2];                            ///< For a delay that is too long, too short: log of a ratio of likelihoods, >= 0.
    float    gain[2];                                ///< Of the cycle at work: what its orders say so far, before `scale`.
    float    scale, usual;                           ///< Factor of `gain`; share by which the means follow in a cycle.
    uint8_t  order;                                  ///< The next of its orders; 0: none.
    uint8_t  cylinders, begun;                       ///< By firing order; 1: a cycle has been seen.
} sd_watch_t;

/// cylinders: 2 to SD_BALANCE_CYLINDERS_MAX, by firing order, firing evenly.
void sd_watch_init(sd_watch_t *self, uint8_t cylinders);
/// After a gap: what was before it says nothing of what follows; evidence stays.
void sd_watch_resume(sd_watch_t *self);
/// One cycle begins to be weighed: sd_watch_work does it, an order of its patterns a call. deviation: the estimate, of the mean; trim: as
/// it was in this cycle; told: the estimate knew of it, else it only follows; variance: of a deviation; follow: the share of a change that
/// it takes up in a cycle, (0, 1].
void sd_watch_begin(sd_watch_t *self, const float *deviation, const float *trim, bool told, float variance, float follow);
/// True while more of the cycle is left to be weighed; evidence takes it in with the last call.
bool sd_watch_work(sd_watch_t *self);
bool sd_watch_wrong(const sd_watch_t *self);

#ifdef __cplusplus
}
#endif

#endif
