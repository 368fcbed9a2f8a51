/* SPDX-License-Identifier: MIT */
/// sd_fixed_trims.h - fuel trims in an ecu of fixed point: the PI law of document 004 in q31, once a cycle,
///     trim_i -= clamp(gain deviation_i + P (deviation_i - last deviation_i), rate);  trims less their mean;  clamp(trim_i, limit)
/// as sd_balance.h has it, without that block's quieter gain near noise and without its watch over the phase. Trims hold while
/// the estimate is not valid, states more than balance.sd_max, or the engine moves, and for balance.hold_cycles cycles after.
#ifndef SD_FIXED_TRIMS_H
#define SD_FIXED_TRIMS_H
#include "sd_afr_chain.h"
#include "sd_signals.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What the trims are to be made from.
typedef enum sd_trims_wish {
    SD_TRIMS_OFF,    ///< The controller forbids trims, or no source is chosen: they are 0.
    SD_TRIMS_LEARN,  ///< They follow the mixture.
    SD_TRIMS_FREEZE, ///< It is not known what the controller wants: they stay as they are.
} sd_trims_wish_t;

/// All zero is a valid start.
typedef struct sd_fixed_trims {
    sd_q31_t trim[SD_CYLINDERS_MAX]; ///< Fuel factor less 1, by firing order.
    sd_q31_t last[SD_CYLINDERS_MAX]; ///< Deviations of the last cycle that moved them, share of the mean.
    uint16_t hold;                   ///< Cycles left on hold.
    uint8_t  has_last, at_limit, not_built; ///< 1: `last` is there; a trim is at its limit; what was wished is not in this ecu.
} sd_fixed_trims_t;

/// Trims to 0, all forgotten.
void sd_fixed_trims_restart(sd_fixed_trims_t *self);
/// Moves the trims by the cycle that ended; transient: speed or fuel moves.
void sd_fixed_trims_cycle(sd_fixed_trims_t *self, const sd_parameters_t *p, uint32_t cylinders, sd_trims_wish_t wish,
                          const sd_afr_estimate_t *estimate, uint8_t health, bool transient);
/// Valid while learning; degraded on hold or at a limit; invalid when the source is not built.
sd_status_t sd_fixed_trims_status(const sd_fixed_trims_t *self);

#ifdef __cplusplus
}
#endif
#endif
