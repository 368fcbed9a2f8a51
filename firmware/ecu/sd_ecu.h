/* SPDX-License-Identifier: MIT */
/// sd_ecu.h - the application core: takes events from a port, runs the blocks that are due, sends what they say.
///
///   crank edge -> crank decoder -> torque observer -> signals of rate "edge"; at the end of a cycle those of "cycle"
///                               -> filter on tooth times -> misfire monitor -> with each firing read, signals of rate
///                                  "firing"
///   cam edge   -> phase
///   time       -> stall detection, which inputs are stale, signals of rate "task", and the answer that all up to now is done
///   sample     -> kept as the latest reading of its sensor; those of the lambda sensor are averaged between teeth
///   wheel edge -> known, and nothing takes it yet
///   gap        -> events were lost: angle and phase are unknown until they are found again
///   parameter  -> the working page; since events are handled one by one, a change falls between two teeth
///
/// With an exhaust in the calibration every tooth also steps the AFR blocks, and every cycle the fuel trims.
///
/// Real-time contract: no heap, no globals, no I/O of its own; one writer. Call sd_ecu_run from the tooth interrupt or
/// whenever the port may hold events.
#ifndef SD_ECU_H
#define SD_ECU_H
#include "hal.h"
#include "sd_balance.h"
#include "sd_calibration.h"
#include "sd_firings.h"
#include "sd_learned.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Latest reading of a sampled sensor.
typedef struct sd_sample {
    float    value; ///< In the unit and within the range of sd_input_infos.
    uint32_t tick;  ///< When it was taken.
    uint8_t  seen;  ///< 0: never read since init; value is 0 then.
    uint8_t  stale; ///< 1: it was older than sd_input_infos allow when a clock event came.
} sd_sample_t;

typedef union sd_torque {
    sd_fourier_f32_t f32;
    sd_fourier_q31_t q31;
} sd_torque_t;

/// Firings read since the end of the last cycle, for the trims.
typedef struct sd_cycle_firings {
    float   torque_nm[SD_CYLINDERS_MAX], sd_nm[SD_CYLINDERS_MAX]; ///< By firing order; as last read.
    uint8_t count;   ///< How many were read.
    uint8_t health;  ///< The worst of them.
    uint8_t misfired; ///< One was judged a misfire.
} sd_cycle_firings_t;

/// The work of a cycle that is still to be done.
typedef struct sd_cycle_work {
    float   deviation[SD_CYLINDERS_MAX], sd[SD_CYLINDERS_MAX]; ///< Of each cylinder, from the trims' source, by firing order.
    uint8_t health;    ///< Of them.
    uint8_t transient; ///< Speed or fuel moved, something did not burn, or a probe is on.
    uint8_t piece;     ///< The next piece, 0: none.
} sd_cycle_work_t;

typedef struct sd_ecu {
    sd_calibration_t calibration; ///< Its parameters are the working page.
    sd_parameters_t  reference;   ///< The page as it came.
    sd_crank_t       crank;
    sd_torque_t      torque;      ///< Which one: torque.fixed_point.
    sd_firings_t     firings;     ///< On tooth times; runs when the page has its tables.
    sd_misfire_t     misfire;
    float    fuel_mg[SD_CYLINDERS_MAX]; ///< Commanded at the last TDC of each firing; below 0: unknown.
    sd_afr_t     afr;             ///< Idle without an exhaust in the calibration.
    sd_afr_delay_t afr_delay;     ///< Idle as afr is; what it learned survives a loss of sync.
    sd_balance_t balance;
    float    burned_sum;          ///< Of the wide-band samples since the last tooth,
    uint32_t burned_count;        ///< and how many.
    sd_cycle_firings_t cycle_firings;
    sd_cycle_work_t work;
    float    fuel_trim[SD_BALANCE_CYLINDERS_MAX]; ///< As commanded, by firing order: the balance's and a probe's.
    float    last_trim[SD_BALANCE_CYLINDERS_MAX]; ///< Of the last cycle.
    uint8_t  probe_done;          ///< With or without an answer, since the trims were allowed.
    float    last_variance;       ///< Of a cylinder's mixture, of the mean, last cycle.
    float    last_speed_radps, last_fuel_mg; ///< Of the last cycle, for transients.
    uint32_t burned_seen;         ///< Samples in this cycle.
    sd_sample_t  sample[SD_INPUT_COUNT]; ///< By sd_input_t.
    sd_signals_t signals;         ///< Present values.
    sd_status_t  status[SD_OWNER_COUNT]; ///< Health of each owner's signals.
    uint32_t cycle_ticks;         ///< Of the cycle so far.
    uint32_t cycle_positions;     ///< Placed in it.
    uint16_t cycle_position;      ///< Of the last placed tooth.
    uint8_t  following;           ///< The torque observer follows the teeth.
    uint8_t  cycle_clean;         ///< Nothing was wrong with the torque in this cycle so far, but that it may converge.
    uint32_t unknown_events;      ///< Ignored, wraps.
    uint32_t bad_samples;         ///< Of an unknown sensor, out of range or NaN; ignored, wraps.
    uint32_t unsent_signals;      ///< The port had no room, wraps.
} sd_ecu_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_ecu_init(sd_ecu_t *self, const sd_calibration_t *calibration);

/// Goes on with a tooth pattern kept from before. SD_OK, or SD_ERR_CONFIG with nothing changed: it is of another wheel, or
/// the page has no filter.
sd_result_t sd_ecu_resume(sd_ecu_t *self, const sd_pattern_sums_t *learned);

/// Handles all events waiting at the port; returns how many.
uint32_t sd_ecu_run(sd_ecu_t *self, const sd_port_t *port);

#ifdef __cplusplus
}
#endif

#endif
