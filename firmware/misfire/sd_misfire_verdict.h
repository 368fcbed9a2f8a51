/* SPDX-License-Identifier: MIT */
/// sd_misfire_verdict.h - what is said of a firing, whoever judges it.
#ifndef SD_MISFIRE_VERDICT_H
#define SD_MISFIRE_VERDICT_H

#ifdef __cplusplus
extern "C" {
#endif

/// Why a firing was not judged; bits.
typedef enum sd_inhibit {
    SD_INHIBIT_START    = 1 << 0, ///< The engine, or the estimator, has just started.
    SD_INHIBIT_FUEL_CUT = 1 << 1, ///< No or hardly any fuel, or too little torque expected.
    SD_INHIBIT_SHIFT    = 1 << 2, ///< The caller says so, or speed changes as it does in a gear shift.
    SD_INHIBIT_ESTIMATE = 1 << 3, ///< The torque is invalid or no number.
    SD_INHIBIT_HOLD     = 1 << 4, ///< Fuel cut or a shift ended a moment ago.
    SD_INHIBIT_OUTSIDE  = 1 << 5, ///< Asked for by the caller.
    SD_INHIBIT_LEVEL    = 1 << 6, ///< The caller says that the tank is nearly empty.
} sd_inhibit_t;

/// What a firing is found to be.
typedef enum sd_verdict {
    SD_HEALTHY      = 0, ///< It burned.
    SD_PARTIAL_BURN = 1, ///< It burned in part.
    SD_MISFIRE      = 2, ///< It gave less than the configured share of the work.
    SD_NOT_JUDGED   = 3, ///< sd_inhibit_t says why.
} sd_verdict_t;

#ifdef __cplusplus
}
#endif

#endif
