/* SPDX-License-Identifier: MIT */
/// sd_fixed_mixture.h - the exhaust side in an ecu of fixed point: document 004's chain in q31 at its operating point. It does what
/// sd_stage_mixture.h does, without the joint filter and what stands on that.
#ifndef SD_FIXED_MIXTURE_H
#define SD_FIXED_MIXTURE_H
#include "sd_calibration.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_MIXTURE_STEPS   2u  ///< Positions stepped at one tooth.
#define SD_MIXTURE_WAITING 32u ///< Positions that may wait, a power of two; more begin anew.

/// Samples of a sensor since the last tooth.
typedef struct sd_fixed_mean {
    int64_t  sum;   ///< Of the samples, each in q31.
    uint32_t count; ///< Of them.
} sd_fixed_mean_t;

/// Owned by the stage; idle without an exhaust in the page, or with a method that is not the chain's.
typedef struct sd_fixed_mixture {
    sd_afr_point_q31_t point;
    sd_afr_chain_q31_t chain;
    sd_fixed_mean_t air, pressure;  ///< Air fraction, and bar over SD_EXHAUST_BAR.
    sd_q31_t waiting_air[SD_MIXTURE_WAITING], waiting_pressure[SD_MIXTURE_WAITING]; ///< At positions not yet stepped: air fraction, and
                                                                                    ///< pressure per unit of SD_EXHAUST_BAR bar.
    uint16_t waiting_position;      ///< Cycle position of the oldest of them.
    uint8_t  waiting_first, waiting_count; ///< Where the oldest of them stands; how many there are.
    uint16_t cycle_positions; ///< Wheel positions in a cycle.
    uint32_t cycle_samples;         ///< Of lambda, in this cycle.
    uint32_t cycles;                ///< Since a start.
    uint8_t  present;               ///< 0: idle, and the page has no exhaust; 1: idle, for the method is not built; 2: it runs.
    uint8_t  oscillators;           ///< How the sensor is inverted: 0 by the document's law.
    uint8_t  slow;                  ///< As in sd_afr_t.
    uint8_t  placed;                ///< A point has been set.
} sd_fixed_mixture_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched. Also for other parameters: the chain begins anew.
sd_result_t sd_fixed_mixture_init(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// The angle is lost, or moved.
void sd_fixed_mixture_restart(sd_fixed_mixture_t *self);
/// A reading of the lambda sensor: air to fuel over stoichiometric; stoichiometric: air to fuel of the fuel.
void sd_fixed_mixture_sample(sd_fixed_mixture_t *self, float lambda, float stoichiometric);
/// A reading of the pressure in the exhaust manifold, bar.
void sd_fixed_mixture_pressure(sd_fixed_mixture_t *self, float bar);
/// Whether a pressure that is measured takes part in the estimate.
bool sd_fixed_mixture_takes_pressure(const sd_fixed_mixture_t *self);
/// A placed tooth: as sd_stage_mixture_tooth.
bool sd_fixed_mixture_tooth(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, uint32_t most);
/// Notes the operating point of the coming cycle and says what the chain found.
void sd_fixed_mixture_read(sd_fixed_mixture_t *self, const sd_afr_conditions_t *at, sd_afr_estimate_t *out, sd_status_t *status);
/// The operating point's tables, in parts. True while more is left.
bool sd_fixed_mixture_work(sd_fixed_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p);

#ifdef __cplusplus
}
#endif
#endif
