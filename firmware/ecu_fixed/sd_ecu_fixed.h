/* SPDX-License-Identifier: MIT */
/// sd_ecu_fixed.h - an ecu of fixed point, for cores without a floating-point unit: the interface of sd_ecu.h, and no floating-point
/// arithmetic in it (docs/theory/fixed.md).
///
///   crank edge -> decoder -> course of the cycle -> torque (Fourier), misfires (document 000), mixture (document 004's chain)
///                 and one piece of the work that the end of a cycle left: cylinders, mixture, trims, the cycle's signals, the
///                 operating point
///   time event -> every 10 ms: which inputs are fresh, air path (document 001)
///   cam edge, sample, gap, parameter: as in sd_ecu.h
///
/// Numbers on the tooth are q31. What a float of the page, of a parameter or of an event means, and what is said as one, is
/// converted by integers (sd_scaled.h); so is what is done once a cycle. The filters on tooth times and all that stands on them
/// (torque of single firings, the misfire monitor, trims from torque), the joint filter on the lambda sensor with the delay that it
/// learns, and the watch over the trims are not in it: owners that have nothing to say are invalid because of SD_WHY_NOT_BUILT.
///
/// Real-time contract: as in sd_ecu.h.
#ifndef SD_ECU_FIXED_H
#define SD_ECU_FIXED_H
#include "hal.h"
#include "sd_calibration.h"
#include "sd_course.h"
#include "sd_fixed_misfire.h"
#include "sd_fixed_mixture.h"
#include "sd_fixed_trims.h"
#include "sd_inputs.h"
#include "sd_publish.h"
#include "sd_stage_airpath.h"
#include "sd_stage_work.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Work of a cycle's end, one piece at a time.
typedef struct sd_work {
    sd_cycle_t cycle;           ///< That ended.
    sd_status_t torque;         ///< Of the Fourier observer at its end.
    sd_afr_estimate_t mixture;  ///< What the mixture stage said of the last cycle.
    sd_status_t mixture_status; ///< How good `mixture` is.
    uint16_t   said;            ///< Signals of its row already sent.
    uint8_t    piece;           ///< The piece that comes next.
    uint8_t    part;            ///< How many parts of it are done.
    uint8_t    steady;          ///< 1: neither speed nor fuel moved, and all fuel burned.
} sd_work_t;

/// State: plain data, caller-owned, without pointers into itself; write none of its fields.
typedef struct sd_ecu {
    sd_parameters_t    working;   ///< The parameters that rule.
    sd_parameters_t    reference; ///< As they came with the page.
    sd_inputs_t        inputs;
    sd_crank_t         crank;
    sd_course_t        course;
    sd_fourier_q31_t   torque;
    sd_fourier_q31_t   torque_ended; ///< As it was at the end of the last cycle, from which cylinders are read.
    sd_fourier_estimate_t ended;  ///< What that says.
    sd_work_meter_t    energy;    ///< Work of a cycle.
    sd_fixed_misfire_t misfire;
    sd_fixed_mixture_t mixture;
    sd_fixed_trims_t   trims;
    sd_stage_airpath_q31_t airpath;
    sd_stage_airpath_crank_t airpath_crank; ///< What the crank said at the last task.
    sd_stage_airpath_out_t airpath_out;     ///< What the air path said at the last task.
    sd_work_t          work;
    sd_publish_t       say;
    float    last_speed_radps, last_fuel_mg; ///< Of the last cycle, to see whether the engine is steady.
    uint32_t unknown_events; ///< Ignored, wraps.
    uint32_t task_tick;      ///< Of the last time event.
    volatile uint8_t task;   ///< 0; 1: the long part of the 10 ms task is due; 2: it is done, and not said yet.
    uint8_t  ready;          ///< 1: initialised.
    uint8_t  shed;           ///< sd_shed_t: what the port lets it leave out.
    uint8_t  edge_seen;      ///< 1: a crank edge came since the last time event.
    uint8_t  misfired;       ///< 1: a firing of this cycle was judged a misfire.
    uint8_t  trims_wanted;   ///< 1: when balance.enable was last fresh, it allowed trims.
} sd_ecu_t;

/// As in sd_ecu.h: SD_OK, or SD_ERR_CONFIG.
sd_result_t sd_ecu_init(sd_ecu_t *self, const sd_calibration_t *page);
/// As in sd_ecu.h.
uint32_t sd_ecu_run(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port);
/// As in sd_ecu.h.
void sd_ecu_task_run(sd_ecu_t *self, const sd_calibration_t *page);

#ifdef __cplusplus
}
#endif
#endif
