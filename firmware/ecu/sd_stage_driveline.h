/* SPDX-License-Identifier: MIT */
/// sd_stage_driveline.h - the driveline in the ecu: torsion of the shaft from teeth, document 003's observers beside it, and a torque
/// request that takes the swing out.
///
/// On the tooth runs the guard filter (sd_driveline_guard.h), with torque, learned place of the tooth and gear as values. In the 10 ms task
/// run document 003's location observer and continuous observer (sd_driveline_hybrid.h) on the speed of the last tooth and the mean torque
/// since the last task. They are the reference, and say nothing to anybody else.
///
/// The engine's torque is the cylinders', as the filter on tooth times has it, less what the engine file says that friction
/// takes. Kinetic energy is that of the crank's mean inertia: teeth are shifted by where its ripple puts them.
///
/// A firing winds the shaft up and lets it go again. So whether the driveline moves, and what the damping answers, is the torsion's change
/// over a period of the firings, over its time; out.winding_radps and out.moving are that and not the filter's own.
///
/// A page without a driveline costs a branch a tooth, and nothing is said.
#ifndef SD_STAGE_DRIVELINE_H
#define SD_STAGE_DRIVELINE_H
#include "sd_calibration.h"
#include "sd_driveline_damping.h"
#include "sd_driveline_guard.h"
#include "sd_driveline_hybrid.h"
#include "sd_firings.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What other stages say at a tooth.
typedef struct sd_stage_driveline_in {
    float    engine_nm;   ///< Torque of all cylinders at the tooth, friction and load not taken off; meant where `torque` is valid.
    float    late_rad;    ///< How far behind its place the tooth stands by the learned pattern, rad.
    sd_status_t torque;   ///< Of engine_nm.
    uint8_t  gear;        ///< 1 to 8; 0: none is engaged, the clutch is open or slips, or nothing is known.
} sd_stage_driveline_in_t;

/// Owned by the stage.
typedef struct sd_stage_driveline {
    sd_driveline_guard_f32_t   guard;
    sd_driveline_hybrid_t  hybrid;
    sd_driveline_damping_t damping;
    sd_driveline_damping_config_t choice; ///< Of the damping, from the parameters that rule.
    sd_driveline_out_f32_t        out;        ///< Of the last tooth.
    sd_driveline_hybrid_out_t reference;  ///< Of the last task.
    float    before_nm;    ///< Torque of all cylinders at the last tooth.
    float    mean_nm;      ///< Of the engine, over some 64 teeth.
    float    torque_nms;   ///< Torque told since the last task, times time.
    float    task_s;       ///< The time that `torque_nms` covers.
    uint32_t tick;         ///< Of the last placed tooth.
    float    begun_rad;    ///< Torsion when the firing period under way began.
    float    begun_s;      ///< How long ago the firing period under way began.
    float    still_s;      ///< For how long the shaft has moved less than the tables' limit, from period to period.
    uint16_t positions;    ///< Passed in it.
    uint8_t  hybrid_gear;  ///< That the reference runs in; 0: it rests.
} sd_stage_driveline_t;

/// Forgets everything. SD_OK; or SD_ERR_CONFIG when a number of the page's driveline or a parameter is out of its range. Without a
/// driveline in the page it does nothing.
sd_result_t sd_stage_driveline_init(sd_stage_driveline_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Other parameters from the next tooth on. SD_OK, or SD_ERR_CONFIG with nothing changed.
sd_result_t sd_stage_driveline_configure(sd_stage_driveline_t *self, const sd_parameters_t *p);

/// The angle was lost or moved: the observers begin anew. What they say until then is invalid, because of `why`, sd_why_t bits.
void sd_stage_driveline_restart(sd_stage_driveline_t *self, uint16_t why);
/// A placed tooth. `driveline` is the page's.
void sd_stage_driveline_tooth(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline, const sd_tooth_t *tooth,
                              const sd_stage_driveline_in_t *in);
/// An edge of a wheel's teeth at `tick`.
void sd_stage_driveline_wheel(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline, uint16_t wheel, uint32_t tick);
/// The 10 ms task.
void sd_stage_driveline_task(sd_stage_driveline_t *self, const sd_page_driveline_t *driveline);

/// Whether the shaft winds or unwinds fast, sd_driveline_word_t; unknown while the estimate is invalid.
static inline uint8_t sd_stage_driveline_word(const sd_stage_driveline_t *self) {
    if (self->out.status.health == (uint8_t)SD_INVALID) { return (uint8_t)SD_DRIVELINE_UNKNOWN; }
    return (uint8_t)((self->out.moving != 0u) ? SD_DRIVELINE_MOVES : SD_DRIVELINE_STILL);
}

#ifdef __cplusplus
}
#endif
#endif
