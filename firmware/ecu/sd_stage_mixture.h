/* SPDX-License-Identifier: MIT */
/// sd_stage_mixture.h - the exhaust side in the ecu: composition of every cylinder's gas, and the delay to the lambda sensor.
///
/// A tooth steps the blocks by as many positions as it passed, but by no more than the ecu has time for: what is left waits for
/// the next teeth, so that a mark or a firing costs no more than its share. The end of a cycle is a list of pieces, see sd_ecu_cycle.c.
#ifndef SD_STAGE_MIXTURE_H
#define SD_STAGE_MIXTURE_H
#include "sd_calibration.h"
#include "sd_stage_trims.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_MIXTURE_STEPS   2u  ///< Positions stepped at one tooth.
#define SD_MIXTURE_WAITING 32u ///< Positions that may wait, a power of two; more begin anew.

/// Owned by the stage; idle without an exhaust in the page.
typedef struct sd_stage_mixture {
    sd_afr_t       afr;
    sd_afr_delay_t delay;           ///< What it learned survives a loss of sync.
    float    burned_sum;            ///< Sum of the burned shares sampled since the last tooth.
    uint32_t burned_count;          ///< How many samples `burned_sum` holds.
    uint32_t cycle_samples;         ///< Samples in this cycle.
    float    pressure_sum;          ///< The same of the pressure in the manifold, bar.
    uint32_t pressure_count;        ///< How many samples `pressure_sum` holds.
    float    waiting[SD_MIXTURE_WAITING]; ///< Burned share at positions not yet stepped, or SD_AFR_NO_SAMPLE.
    float    waiting_bar[SD_MIXTURE_WAITING]; ///< Pressure in the manifold at those positions; 0: no sample.
    uint16_t waiting_position;      ///< Cycle position of the oldest of them.
    uint8_t  waiting_first, waiting_count; ///< Where the oldest of them stands; how many there are.
    float    last_trim[SD_BALANCE_CYLINDERS_MAX]; ///< Trims of the last cycle, by firing order: fuel factor less 1.
    float    last_variance;         ///< Of a cylinder's mixture, of the mean, last cycle.
    float    egr_share;             ///< Recirculated of all that leaves the manifold, mean of some cycles; 0: none, or not known.
    uint8_t  probe_done;            ///< With or without an answer, since the trims were allowed.
} sd_stage_mixture_t;

/// What is known at the end of a cycle.
typedef struct sd_mixture_cycle {
    float    speed_radps;    ///< Mean of the cycle.
    bool     steady;         ///< Neither speed nor fuel moves, and everything burned.
    bool     trimming;       ///< Trims are wanted.
    bool     diverged;       ///< They were given up, because their phase is wrong.
    uint32_t trims_learned;  ///< Cycles in which they moved.
    const float *trim;       ///< As commanded, by firing order: fuel factor less 1.
} sd_mixture_cycle_t;

/// What is known of recirculation at the end of a cycle; at->egr_share is not read.
typedef struct sd_mixture_egr {
    const sd_afr_conditions_t *at; ///< Speed, pressure, fuel and temperature; not NULL.
    float stoichiometric;    ///< Stoichiometric air to fuel ratio, by mass.
    float air_gps;           ///< Fresh air; 0: not known.
    float opening;           ///< Share that the valve is open, 0 closed, 1 open; 0: not known, and there is taken to be none.
} sd_mixture_egr_t;

/// What the stage says of a cycle, by firing order.
typedef struct sd_mixture_out {
    float   burned[SD_CYLINDERS_MAX]; ///< Burned share of each cylinder's gas: 1 - air/gas.
    sd_deviations_t deviations;
    sd_status_t status;
} sd_mixture_out_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_stage_mixture_init(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Goes on with what was kept of delay and lags; nothing to do without an exhaust in the page. SD_OK, or SD_ERR_CONFIG with the state
/// untouched: it is of another sensor (sd_afr_delay_resume).
sd_result_t sd_stage_mixture_resume(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p,
                                    const sd_afr_kept_t *kept);
/// What to keep; all 0 without an exhaust in the page.
void sd_stage_mixture_keep(const sd_stage_mixture_t *self, const sd_calibration_t *page, sd_afr_kept_t *kept);
/// Other parameters: the filter begins anew, what was learned of the delay stays. SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_stage_mixture_configure(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// The angle is lost, or moved.
void sd_stage_mixture_restart(sd_stage_mixture_t *self);
/// A reading of the lambda sensor: air to fuel over stoichiometric; stoichiometric: air to fuel of the fuel.
void sd_stage_mixture_sample(sd_stage_mixture_t *self, float lambda, float stoichiometric);
/// A reading of the pressure in the exhaust manifold, bar.
void sd_stage_mixture_pressure(sd_stage_mixture_t *self, float bar);
/// Whether a pressure that is measured takes part in the estimate.
bool sd_stage_mixture_takes_pressure(const sd_stage_mixture_t *self);
/// A placed tooth: its positions wait, and the oldest that wait are stepped, `most` of them. True when more than the tooth's own
/// position was stepped.
bool sd_stage_mixture_tooth(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, uint32_t most);
/// End of a cycle, first piece: the trims are told to the filter, and the delay learns from them. True: the delay was found to be far
/// off, so that the trims' loop is another one now.
bool sd_stage_mixture_learn(sd_stage_mixture_t *self, const sd_parameters_t *p, const sd_mixture_cycle_t *cycle);
/// The share of what leaves the manifold that is recirculated, [0, SD_AFR_EGR_MAX]. By mass: what cylinders aspirate (intake pressure and
/// the calibration's air for it) and fuel, less fresh air and fuel. Fresh air is the meter's, or what the mean lambda m of the exhaust has
/// left, (1 + s) fuel/m less the fuel, which holds with recirculation too once the mixture stands. Mean of some 10 cycles; 0 while the
/// valve
/// is shut.
float sd_stage_mixture_recirculated(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_mixture_egr_t *egr);
/// Next piece: notes the operating point of the coming cycle and says what the filter found.
void sd_stage_mixture_read(sd_stage_mixture_t *self, const sd_afr_conditions_t *at, sd_mixture_out_t *out);
/// Last pieces: the operating point's tables. True while more is left.
bool sd_stage_mixture_work(sd_stage_mixture_t *self, const sd_calibration_t *page);
/// The probe's trim of each cylinder, by firing order; size: of the whole probe. 0 while none runs.
void sd_stage_mixture_probe(const sd_stage_mixture_t *self, float size, float *trim);

#ifdef __cplusplus
}
#endif
#endif
