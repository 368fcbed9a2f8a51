/* SPDX-License-Identifier: MIT */
/// sd_ecu.h - the application core: takes events from a port, runs the stages that are due, sends what they say.
///
///   crank edge -> decoder -> course of the cycle -> torque, firings (-> misfire, at each firing read), driveline, mixture
///                 and one piece of the work that the end of a cycle left: cylinders, delay, mixture, trims, the cycle's signals
///   cam edge   -> phase
///   wheel edge -> driveline
///   time       -> every 10 ms: age of inputs, stall, diagnosis of the air path, document 003's observers, signals of that rate, and the
///                 answer that all up to now
///                 is done
///   sample     -> inputs; those of the lambda sensor and of the exhaust pressure are averaged between teeth
///   gap        -> events were lost: angle and phase are unknown until they are found again
///   parameter  -> the working parameters; since events are handled one by one, a change falls between two teeth
///
/// Each stage owns a struct of its own, takes values and hands values on; only this file wires them together. Tables are read from
/// the page, where it lies.
///
/// Real-time contract: no heap, no globals, no I/O of its own; one writer. Call sd_ecu_run from the tooth interrupt or
/// whenever the port may hold events. Work is counted in events, never in time, so the same events give the same answers on every port
/// and target.
///
/// With SD_ECU_FIXED the same interface is that of an ecu of fixed point: sd_ecu_fixed.h.
#ifndef SD_ECU_H
#define SD_ECU_H
#ifdef SD_ECU_FIXED
#include "sd_ecu_fixed.h"
#else
#include "hal.h"
#include "sd_calibration.h"
#include "sd_firings.h"
#include "sd_inputs.h"
#include "sd_learned.h"
#include "sd_publish.h"
#include "sd_punctual.h"
#include "sd_stage_driveline.h"
#include "sd_stage_airpath.h"
#include "sd_stage_misfire.h"
#include "sd_stage_mixture.h"
#include "sd_stage_torque.h"
#include "sd_stage_trims.h"
#include "sd_stage_work.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Work of a cycle's end, one piece at a time.
typedef struct sd_work {
    sd_cycle_t cycle;         ///< That ended.
    sd_status_t torque;       ///< Of the Fourier observer at its end.
    sd_mixture_out_t mixture; ///< What the mixture stage said of it.
    uint16_t   said;          ///< Signals of its row already sent.
    uint8_t    piece;         ///< sd_piece_t that comes next.
    uint8_t    steady;        ///< 1: neither speed nor fuel moved, and everything burned.
} sd_work_t;

/// State: plain data, caller-owned, without pointers into itself; write none of its fields.
typedef struct sd_ecu {
    sd_parameters_t    working;   ///< The parameters that rule.
    sd_parameters_t    reference; ///< As they came with the page.
    sd_inputs_t        inputs;
    sd_crank_t         crank;
    sd_course_t        course;
    sd_stage_torque_t  torque;
    sd_punctual_t      punctual; ///< Of the teeth that the Fourier observer is given.
    sd_firings_t       firings;
    sd_work_meter_t    energy;  ///< Work of a cycle.
    sd_stage_misfire_t misfire;
    sd_stage_mixture_t mixture;
    sd_stage_trims_t   trims;
    sd_stage_driveline_t driveline; ///< Rests where the page has none.
    sd_stage_airpath_t airpath;
    sd_stage_airpath_crank_t airpath_crank; ///< What the crank said at the last time event.
    sd_stage_airpath_out_t   airpath_out;   ///< Of the last task.
    sd_work_t          work;
    sd_publish_t       say;
    float    last_speed_radps, last_fuel_mg; ///< Of the last cycle, to see whether the engine is steady.
    uint32_t unknown_events; ///< Ignored, wraps.
    uint32_t task_tick;      ///< Of the last time event.
    volatile uint8_t task;   ///< 0; 1: the long part of the 10 ms task is due; 2: it is done, and not said yet.
    uint8_t  ready;          ///< 1: initialised.
    uint8_t  shed;           ///< sd_shed_t: what the port lets it leave out.
    uint8_t  edge_seen;      ///< 1: a crank edge came since the last time event.
    uint8_t  driveline_word; ///< sd_driveline_word_t of the last tooth, for the firings of the next.
    uint8_t  trims_wanted;   ///< 1: when balance.enable was last fresh, it allowed trims.
} sd_ecu_t;

/// SD_OK; or SD_ERR_CONFIG when a number of the page is out of its range, and the state is such that sd_ecu_run does nothing. The same
/// page goes with every later call.
sd_result_t sd_ecu_init(sd_ecu_t *self, const sd_calibration_t *page);

/// Goes on with what was kept from before; behind sd_ecu_init, before the first event. SD_OK, or SD_ERR_CONFIG with nothing changed: it is
/// of another wheel or another lambda sensor, or the page has neither filter nor exhaust.
sd_result_t sd_ecu_resume(sd_ecu_t *self, const sd_calibration_t *page, const sd_kept_t *kept);
/// What to keep while the engine is off.
void sd_ecu_keep(const sd_ecu_t *self, const sd_calibration_t *page, sd_kept_t *kept);

/// Handles all events waiting at the port; returns how many.
uint32_t sd_ecu_run(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port);

/// The long part of the 10 ms task, where the port has put it off (SD_TIME_PUT_OFF); nothing where it has not. To be called at a lower
/// priority than sd_ecu_run, which may interrupt it with edges and SD_EVENT_LATE, but until SD_EVENT_TASK with nothing else.
void sd_ecu_task_run(sd_ecu_t *self, const sd_calibration_t *page);

#ifdef __cplusplus
}
#endif
#endif /* SD_ECU_FIXED */
#endif
