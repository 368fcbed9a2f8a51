/* SPDX-License-Identifier: MIT */
/// sd_status.h - what every block of sixdeg says about its outputs.
#ifndef SD_STATUS_H
#define SD_STATUS_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// How far an output may be trusted. Ordered: a larger value is never more trustworthy than a smaller one.
typedef enum sd_health {
    SD_VALID    = 0, ///< Use it.
    SD_DEGRADED = 1, ///< Plausible, but a reason is set: good for display, not for control.
    SD_INVALID  = 2, ///< Do not use it; the value is the last good one or zero, never NaN.
} sd_health_t;

/// Why health is not SD_VALID; bits, several may be set. Kept in 16 bits.
typedef enum sd_why {
    SD_WHY_NO_SYNC      = 1 << 0, ///< The crank angle is unknown.
    SD_WHY_NO_PHASE     = 1 << 1, ///< Which of the two revolutions of a cycle is unknown: cylinders may be swapped.
    SD_WHY_FAULT        = 1 << 2, ///< A missing, doubled or spurious edge stands in or right before this value.
    SD_WHY_STALL        = 1 << 3, ///< The engine stands still, or turns slower than the decoder follows.
    SD_WHY_CONVERGING   = 1 << 4, ///< The observer started or restarted less than its settling time ago.
    SD_WHY_REJECTED     = 1 << 5, ///< The measurement was too far from its prediction and was left out.
    SD_WHY_UNCALIBRATED = 1 << 6, ///< The calibration page does not hold what this value takes.
    SD_WHY_NO_INPUT     = 1 << 7, ///< A sensor that this value takes has not been read; a usual value stands for it.
    SD_WHY_STALE_INPUT  = 1 << 8, ///< A sensor that this value takes was last read longer ago than its reading counts.
    SD_WHY_NOT_BUILT    = 1 << 9, ///< This build of the firmware does not hold the block.
    SD_WHY_OVERLOAD     = 1 << 10, ///< Left out, since teeth came faster than the controller handles them; see hal/sd_shed.h.
    SD_WHY_LEARNED      = 1 << 11, ///< It rests on something learned since the start that is too large to be trusted.
} sd_why_t;

/// Outcome of an init or a command. 0 is success; a negative value leaves the state as it was.
typedef enum sd_result {
    SD_OK         = 0,  ///< Done.
    SD_ERR_CONFIG = -1, ///< A configuration field is outside the range documented beside it (NaN included).
    SD_ERR_PAGE   = -2, ///< A calibration page is truncated, of another version, or its checksum is wrong.
} sd_result_t;

/// The status every block reports.
typedef struct sd_status {
    uint16_t why;        ///< sd_why_t bits, 0 when valid.
    uint16_t rejected;   ///< Measurements left out since init, saturating.
    uint8_t  health;     ///< sd_health_t.
    float    innovation; ///< Last measurement minus its prediction, in the block's own unit.
    float    test_ratio; ///< |innovation| over its acceptance limit; above 1 the measurement was left out.
} sd_status_t;

/// Health becomes no better than this; reasons add up.
static inline void sd_status_worst_of(sd_status_t *status, uint8_t health, uint16_t why) {
    if (health > status->health) { status->health = health; }
    status->why = (uint16_t)(status->why | why);
}

#ifdef __cplusplus
}
#endif

#endif
