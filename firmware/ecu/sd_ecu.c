/* SPDX-License-Identifier: MIT */
#include "sd_ecu.h"

#include <string.h>

#include "sd_ecu_parts.h"
#include "sd_math.h"
#include "sd_say.h"

_Static_assert((SD_AFR_CYLINDERS_MAX == SD_CYLINDERS_MAX) && (SD_BALANCE_CYLINDERS_MAX == SD_CYLINDERS_MAX) &&
               (SD_MISFIRE_CYLINDERS_MAX == SD_CYLINDERS_MAX) && (SD_KALMAN_FIRINGS_MAX == SD_CYLINDERS_MAX),
               "blocks that hold the same engine hold as many cylinders");

sd_result_t sd_ecu_init(sd_ecu_t *self, const sd_calibration_t *page) {
    memset(self, 0, sizeof *self);
    sd_publish_init(&self->say);
    self->work.piece = SD_PIECE_NONE;
    if (!sd_calibration_in_range(page)) { return SD_ERR_CONFIG; }
    const sd_parameters_t *p = &page->parameters;
    const sd_crank_config_t crank = sd_calibration_crank(page, p);
    const sd_firings_config_t firings = sd_ecu_firings_config(page, p);
    const bool ok = (sd_crank_init(&self->crank, &crank) == SD_OK) && (sd_stage_torque_init(&self->torque, page, p) == SD_OK) &&
                    (sd_firings_init(&self->firings, &firings, &page->kalman) == SD_OK) &&
                    (sd_stage_misfire_init(&self->misfire, page, p) == SD_OK) &&
                    (sd_stage_mixture_init(&self->mixture, page, p) == SD_OK) && (sd_stage_trims_init(&self->trims, page, p) == SD_OK) &&
                    (sd_stage_driveline_init(&self->driveline, page, p) == SD_OK) &&
                    (sd_stage_airpath_init(&self->airpath, page, p) == SD_OK);
    if (!ok) { return SD_ERR_CONFIG; }
    self->working = *p;
    self->reference = *p;
    self->ready = 1;
    return SD_OK;
}

sd_result_t sd_ecu_resume(sd_ecu_t *self, const sd_calibration_t *page, const sd_kept_t *kept) {
    const bool filter = self->firings.enabled != 0u;
    if ((self->ready == 0u) || (!filter && (page->afr.present == 0u))) { return SD_ERR_CONFIG; }
    if (sd_stage_mixture_resume(&self->mixture, page, &self->working, &kept->mixture) != SD_OK) { return SD_ERR_CONFIG; }
    if (!filter) { return SD_OK; }
    if (sd_firings_resume(&self->firings, &page->kalman, &kept->pattern) != SD_OK) {
        (void)sd_stage_mixture_init(&self->mixture, page, &self->working); /* as it was: no event has come yet */
        return SD_ERR_CONFIG;
    }
    sd_say_pattern(&self->say, &self->firings);
    return SD_OK;
}

void sd_ecu_keep(const sd_ecu_t *self, const sd_calibration_t *page, sd_kept_t *kept) {
    sd_firings_keep(&self->firings, &page->kalman, &kept->pattern);
    sd_stage_mixture_keep(&self->mixture, page, &kept->mixture);
}

/* ---- a tooth --------------------------------------------------------------------------------------------------- */

static void restart_firings(sd_ecu_t *self) {
    const bool filters = self->firings.enabled != 0u;
    if (filters) { sd_firings_restart(&self->firings); }
    if (!filters && !sd_stage_misfire_observes(&self->misfire)) { return; }
    sd_stage_misfire_restart(&self->misfire);
    sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &self->misfire.status);
}

static void rest_driveline(sd_ecu_t *self, uint16_t why) {
    sd_stage_driveline_restart(&self->driveline, why);
    self->driveline_word = (uint8_t)SD_DRIVELINE_UNKNOWN;
}

static void jump(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, sd_course_jump_t jump) {
    sd_stage_work_jump(&self->energy, page, tooth);
    sd_stage_torque_jump(&self->torque, jump);
    restart_firings(self);
    sd_stage_mixture_restart(&self->mixture);
    rest_driveline(self, SD_WHY_CONVERGING);
}

static void end_cycle(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_cycle_t *cycle) {
    sd_stage_torque_end_cycle(&self->torque);
    sd_stage_trims_end_cycle(&self->trims);
    sd_ecu_begin_work(self, page, port, cycle);
}

/* The Fourier observer gets the times that an even wheel would give, as far as the wheel's pattern is known. */
static void step_torque(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth) {
    const sd_firings_pattern_t pattern = sd_firings_believed(&self->firings);
    sd_tooth_t even = *tooth;
    if (pattern.late_rad != NULL) {
        even.period_ticks = sd_punctual_period(&self->punctual, tooth->period_ticks, tooth->advance,
                                               sd_firings_late(&pattern, tooth->position), (float)page->positions * (1.0f / SD_TWO_PI));
    }
    sd_torque_out_t torque;
    sd_stage_torque_tooth(&self->torque, page, &even, &torque);
    sd_say_torque(&self->say, &torque);
    /* What is read at the end of the cycle has settled by then, or says so itself. */
    const bool good = (torque.status.health != (uint8_t)SD_INVALID) && ((torque.status.why & ~(uint32_t)SD_WHY_CONVERGING) == 0u);
    sd_course_add(&self->course, tooth, good);
}

/* The gear that is in with the clutch closed, as far as anybody says so. */
static uint8_t gear_of(const sd_inputs_t *inputs) {
    const bool shifting = sd_inputs_value(inputs, SD_INPUT_DRIVELINE_SHIFT) > 0.5f;
    return shifting ? (uint8_t)0u : (uint8_t)sd_inputs_value(inputs, SD_INPUT_DRIVELINE_GEAR);
}

/* firings: NULL where no filter runs, and document 000's observer judges alone. */
static void judge_firing(sd_ecu_t *self, const sd_calibration_t *page, uint32_t firing, bool phase_known, const sd_firings_out_t *firings) {
    sd_stage_misfire_in_t in = { .firing = firing,
                                 .phase_known = phase_known,
                                 .geared = gear_of(&self->inputs) != 0u,
                                 .shifting = sd_inputs_value(&self->inputs, SD_INPUT_DRIVELINE_SHIFT) > 0.5f,
                                 .level_known = sd_inputs_fresh(&self->inputs, SD_INPUT_FUEL_LEVEL),
                                 .fuel_level_percent = sd_inputs_value(&self->inputs, SD_INPUT_FUEL_LEVEL) };
    if (firings != NULL) {
        in.read = &firings->firing;
        in.estimate = firings->status;
        in.energy_j = firings->energy_j;
        in.speed_radps = firings->speed_radps;
    }
    sd_stage_misfire_out_t out;
    sd_stage_misfire_firing(&self->misfire, page, &in, &out);
    if (firings != NULL) {
        sd_stage_trims_firing(&self->trims, &firings->firing, firings->status.health, out.verdict.verdict == (uint8_t)SD_MISFIRE);
    }
    sd_say_verdict(&self->say, &out);
    sd_status_t status = self->misfire.status;
    sd_inputs_judge(&self->inputs, SD_OWNER_MISFIRE, &status);
    sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &status);
}

static void step_driveline(sd_ecu_t *self, const sd_page_driveline_t *driveline, const sd_tooth_t *tooth, const sd_firings_out_t *firings) {
    const sd_firings_pattern_t pattern = sd_firings_believed(&self->firings);
    const sd_stage_driveline_in_t in = { .engine_nm = firings->waveform_nm - firings->level_nm,
                                         .late_rad = sd_firings_late(&pattern, tooth->position),
                                         .torque = firings->status,
                                         .gear = gear_of(&self->inputs) };
    sd_stage_driveline_tooth(&self->driveline, driveline, tooth, &in);
    self->driveline_word = sd_stage_driveline_word(&self->driveline);
}

/* Returns true when a firing was read. */
static bool step_firings(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_tooth_t *tooth, float speed_radps) {
    const sd_inputs_t *inputs = &self->inputs;
    const bool fuel_known = sd_inputs_fresh(inputs, SD_INPUT_FUEL_INJECTED);
    const float fuel_mg = fuel_known ? sd_inputs_value(inputs, SD_INPUT_FUEL_INJECTED) : SD_FUEL_UNKNOWN;
    const sd_firings_tooth_t seen = { .cycle_position = tooth->cycle_position,
                                      .position = tooth->position,
                                      .advance = tooth->advance,
                                      .period_ticks = tooth->period_ticks,
                                      .health = tooth->health,
                                      .phase_known = tooth->phase_known,
                                      .intake_known = sd_inputs_fresh(inputs, SD_INPUT_AIR_INTAKE_PRESSURE) ? 1u : 0u,
                                      .fuel_mg = fuel_mg,
                                      .fuel_cut = (fuel_known && (fuel_mg <= 0.0f)) ? 1u : 0u,
                                      .intake_bar = sd_inputs_value(inputs, SD_INPUT_AIR_INTAKE_PRESSURE),
                                      .driveline = self->driveline_word,
                                      .speed_radps = speed_radps };
    sd_firings_out_t out;
    sd_firings_step(&self->firings, &page->kalman, &seen, &out);
    sd_inputs_judge(inputs, SD_OWNER_FIRING, &out.status);
    sd_publish_judge(&self->say, SD_OWNER_FIRING, &out.status);
    self->say.signals.firing_waveform_nm = out.waveform_nm;
    const sd_page_driveline_t *driveline = sd_calibration_driveline(page);
    if (driveline != NULL) { step_driveline(self, driveline, tooth, &out); }
    const bool observed = sd_stage_misfire_observes(&self->misfire);
    if ((self->firings.enabled == 0u) && !observed) {
        sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &out.status);
        return false;
    }
    const uint32_t read = sd_stage_misfire_tooth(&self->misfire, page, tooth, fuel_mg);
    if (out.restarted != 0u) { sd_misfire_start(&self->misfire.monitor); }
    if (out.learned != 0u) { sd_say_pattern(&self->say, &self->firings); }
    if (out.complete != 0u) {
        sd_say_firing(&self->say, page, &out);
        judge_firing(self, page, out.firing.index, tooth->phase_known != 0u, &out);
    } else if ((self->firings.enabled == 0u) && (read != 0u)) {
        self->say.signals.firing_cylinder = (float)page->firing_order[read - 1u];
        judge_firing(self, page, read - 1u, tooth->phase_known != 0u, NULL);
    } else {
        return false;
    }
    sd_publish_row(&self->say, port, tooth->tick, SD_RATE_FIRING);
    return true;
}

void sd_ecu_tooth(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_tooth_t *tooth, float speed_radps) {
    sd_cycle_t cycle;
    const sd_course_jump_t moved = sd_course_follow(&self->course, tooth, page->positions);
    if (moved != SD_COURSE_NONE) { jump(self, page, tooth, moved); }
    if (sd_course_ended(&self->course, tooth, page->positions, page->tick_hz, &cycle)) { end_cycle(self, page, port, &cycle); }
    step_torque(self, page, tooth);
    sd_stage_work_tooth(&self->energy, page, &self->working, tooth, &self->say, port);
    const bool firing_read = (self->shed < (uint8_t)SD_SHED_FIRINGS) && step_firings(self, page, port, tooth, speed_radps);
    /* A tooth has one burden beside its own position: positions passed without an edge, a firing, mixture that waits, or a piece. */
    const bool burdened = firing_read || (tooth->advance > 1u);
    const bool catches_up = (self->shed < (uint8_t)SD_SHED_MIXTURE) &&
                            sd_stage_mixture_tooth(&self->mixture, page, tooth, burdened ? 0u : SD_MIXTURE_STEPS);
    if (!burdened && !catches_up) { sd_ecu_do_piece(self, page, port); }
}

/* ---- beside teeth ---------------------------------------------------------------------------------------------- */

void sd_ecu_spurious(sd_ecu_t *self, const sd_calibration_t *page) {
    if (self->shed >= (uint8_t)SD_SHED_FIRINGS) { return; }
    sd_firings_spurious(&self->firings, &page->kalman);
    sd_stage_misfire_spurious(&self->misfire, page);
}

void sd_ecu_lose_angle(sd_ecu_t *self, uint16_t why) {
    sd_course_lose(&self->course);
    sd_stage_mixture_restart(&self->mixture);
    rest_driveline(self, why);
    self->say.signals.torque_mass_nm = 0.0f;
    sd_publish_worst_of(&self->say, SD_OWNER_TORQUE, SD_INVALID, why);
    sd_publish_worst_of(&self->say, SD_OWNER_FIRING, SD_INVALID, why);
}

float sd_ecu_say_edge(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth) {
    const sd_crank_motion_t motion = sd_crank_motion_of(&self->crank, tooth, page->tick_hz);
    sd_say_tooth(&self->say, page, tooth, &motion);
    return motion.speed_radps;
}

/* A block that followed no teeth for a while starts afresh. */
void sd_ecu_shed(sd_ecu_t *self, uint8_t level) {
    const uint8_t before = self->shed;
    self->shed = level;
    if ((before < (uint8_t)SD_SHED_MIXTURE) != (level < (uint8_t)SD_SHED_MIXTURE)) { sd_stage_mixture_restart(&self->mixture); }
    if ((before < (uint8_t)SD_SHED_FIRINGS) != (level < (uint8_t)SD_SHED_FIRINGS)) {
        restart_firings(self);
        rest_driveline(self, SD_WHY_OVERLOAD);
    }
    if (level >= (uint8_t)SD_SHED_FIRINGS) {
        sd_publish_worst_of(&self->say, SD_OWNER_FIRING, SD_INVALID, SD_WHY_OVERLOAD);
        sd_publish_worst_of(&self->say, SD_OWNER_MISFIRE, SD_INVALID, SD_WHY_OVERLOAD);
    }
}

void sd_ecu_sample(sd_ecu_t *self, sd_input_t input, float value) {
    if (input == SD_INPUT_EXHAUST_LAMBDA) {
        sd_stage_mixture_sample(&self->mixture, value, self->working.afr_stoichiometric);
    } else if (input == SD_INPUT_EXHAUST_PRESSURE) {
        sd_stage_mixture_pressure(&self->mixture, value);
    }
}

void sd_ecu_wheel(sd_ecu_t *self, const sd_calibration_t *page, uint16_t wheel, uint32_t tick) {
    const sd_page_driveline_t *driveline = sd_calibration_driveline(page);
    if (driveline != NULL) { sd_stage_driveline_wheel(&self->driveline, driveline, wheel, tick); }
}

static void driveline_task(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, uint32_t tick) {
    const sd_page_driveline_t *driveline = sd_calibration_driveline(page);
    if (driveline == NULL) { return; }
    sd_stage_driveline_task(&self->driveline, driveline);
    sd_status_t status = self->driveline.out.status;
    sd_inputs_judge(&self->inputs, SD_OWNER_DRIVELINE, &status);
    sd_say_driveline(&self->say, &self->driveline);
    sd_publish_judge(&self->say, SD_OWNER_DRIVELINE, &status);
    sd_publish_judge(&self->say, SD_OWNER_DRIVELINE_REFERENCE, &self->driveline.reference.status);
    sd_publish_row(&self->say, port, tick, SD_RATE_DRIVELINE);
}

void sd_ecu_task_begin(sd_ecu_t *self, const sd_calibration_t *page, uint32_t tick) {
    self->task_tick = tick;
    self->airpath_crank = sd_say_crank_now(&self->say, page->cylinders);
    sd_firings_task_begin(&self->firings);
}

/* Of the inputs only samples and the clock change anything, and these wait for it. Firings and teeth share as sd_fired.h says. */
void sd_ecu_task_work(sd_ecu_t *self, const sd_calibration_t *page) {
    sd_firings_task_work(&self->firings, &page->kalman);
    if (page->airpath.present == 0u) { return; }
    sd_stage_airpath_step(&self->airpath, page, &self->inputs, &self->airpath_crank, self->task_tick, &self->airpath_out);
}

void sd_ecu_task_say(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, uint16_t why) {
    if (sd_firings_task_end(&self->firings)) { sd_say_pattern(&self->say, &self->firings); }
    if (page->airpath.present != 0u) { sd_say_airpath(&self->say, port, self->task_tick, &self->airpath_out, why); }
    driveline_task(self, page, port, self->task_tick);
}
