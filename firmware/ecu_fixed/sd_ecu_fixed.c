/* SPDX-License-Identifier: MIT */
/* An ecu of fixed point: its stages wired. Events come to it through sd_ecu_events.c. */
#include "sd_ecu.h"

#include <string.h>

#include "sd_ecu_parts.h"
#include "sd_fixed_parts.h"
#include "sd_say_airpath.h"
#include "sd_say_edge.h"

static sd_result_t init_torque(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_fourier_config_t config = sd_calibration_torque(page, &self->working);
    return sd_fourier_init_q31(&self->torque, &config, &page->fourier);
}

sd_result_t sd_ecu_init(sd_ecu_t *self, const sd_calibration_t *page) {
    memset(self, 0, sizeof *self);
    sd_publish_init(&self->say);
    self->work.piece = SD_FIXED_NONE;
    if (!sd_calibration_in_range(page)) { return SD_ERR_CONFIG; }
    self->working = page->parameters;
    self->reference = page->parameters;
    const sd_crank_config_t crank = sd_calibration_crank(page, &self->working);
    const bool ok = (sd_crank_init(&self->crank, &crank) == SD_OK) && (init_torque(self, page) == SD_OK) &&
                    (sd_fixed_misfire_init(&self->misfire, page, &self->working) == SD_OK) &&
                    (sd_fixed_mixture_init(&self->mixture, page, &self->working) == SD_OK) &&
                    (sd_stage_airpath_init_q31(&self->airpath, page, &self->working) == SD_OK);
    if (!ok) { return SD_ERR_CONFIG; }
    const sd_status_t not_built = { .health = SD_INVALID, .why = SD_WHY_NOT_BUILT };
    sd_publish_judge(&self->say, SD_OWNER_FIRING, &not_built);
    if (page->airpath.present != page->airpath_q31.present) { sd_publish_judge(&self->say, SD_OWNER_AIRPATH, &not_built); }
    sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &self->misfire.status);
    self->ready = 1;
    return SD_OK;
}

/* ---- a tooth --------------------------------------------------------------------------------------------------- */

static void jump(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, sd_course_jump_t jump) {
    sd_stage_work_jump(&self->energy, page, tooth);
    if (jump == SD_COURSE_SHIFTED) { sd_fourier_shift_revolution_q31(&self->torque); } else { sd_fourier_restart_q31(&self->torque); }
    sd_fixed_misfire_restart(&self->misfire);
    sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &self->misfire.status);
    sd_fixed_mixture_restart(&self->mixture);
}

static bool above_half(float x) { return sd_bits_order(x) > sd_bits_order(0.5f); }

static uint32_t inhibits(const sd_ecu_t *self, const sd_tooth_t *tooth) {
    const sd_inputs_t *inputs = &self->inputs;
    const float level = sd_inputs_value(inputs, SD_INPUT_FUEL_LEVEL), least = self->working.misfire_fuel_level_min_percent;
    uint32_t why = 0;
    if (above_half(sd_inputs_value(inputs, SD_INPUT_DRIVELINE_SHIFT))) { why |= (uint32_t)SD_INHIBIT_SHIFT; }
    const bool known = sd_inputs_fresh(inputs, SD_INPUT_FUEL_LEVEL);
    if (known && (sd_bits_order(level) < sd_bits_order(least))) { why |= (uint32_t)SD_INHIBIT_LEVEL; }
    if (tooth->phase_known == 0u) { why |= (uint32_t)SD_INHIBIT_ESTIMATE; }
    return why;
}

/* Returns true when a firing was read. */
static bool step_misfire(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_tooth_t *tooth) {
    const bool known = sd_inputs_fresh(&self->inputs, SD_INPUT_FUEL_INJECTED);
    const float fuel_mg = known ? sd_inputs_value(&self->inputs, SD_INPUT_FUEL_INJECTED) : -1.0f;
    const uint32_t read = sd_fixed_misfire_tooth(&self->misfire, page, tooth, fuel_mg);
    if (read == 0u) { return false; }
    sd_wheel_verdict_q31_t verdict;
    sd_fixed_misfire_judge(&self->misfire, page, read - 1u, inhibits(self, tooth), &verdict);
    if (verdict.verdict == (uint8_t)SD_MISFIRE) { self->misfired = 1; }
    sd_status_t status = self->misfire.status;
    sd_inputs_judge(&self->inputs, SD_OWNER_MISFIRE, &status);
    sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &status);
    sd_fixed_say_verdict(self, page, &verdict);
    sd_publish_row(&self->say, port, tooth->tick, SD_RATE_FIRING);
    return true;
}

static void step_torque(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth) {
    const uint8_t trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u;
    sd_fourier_advance_q31(&self->torque, &page->fourier, tooth->cycle_position, tooth->advance, tooth->period_ticks, trusted);
    sd_status_t status = sd_fourier_health_q31(&self->torque);
    sd_status_worst_of(&status, tooth->health, tooth->why);
    sd_publish_judge(&self->say, SD_OWNER_TORQUE, &status);
    sd_fixed_say_torque(&self->say, &self->torque);
    const bool good = (status.health != (uint8_t)SD_INVALID) && ((status.why & ~(uint32_t)SD_WHY_CONVERGING) == 0u);
    sd_course_add(&self->course, tooth, good);
}

void sd_ecu_tooth(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_tooth_t *tooth, float speed_radps) {
    sd_cycle_t cycle;
    (void)speed_radps; /* nobody here asks for it */
    const sd_course_jump_t moved = sd_course_follow(&self->course, tooth, page->positions);
    if (moved != SD_COURSE_NONE) { jump(self, page, tooth, moved); }
    if (sd_course_ended(&self->course, tooth, page->positions, page->tick_hz, &cycle)) {
        self->torque_ended = self->torque; /* read by the first piece */
        sd_fixed_begin_work(self, page, port, &cycle);
    }
    step_torque(self, page, tooth);
    const bool skipped = tooth->advance > 1u;
    if (skipped || (tooth->cycle_position == self->energy.waits)) { /* as most teeth are not */
        sd_stage_work_tooth(&self->energy, page, &self->working, tooth, &self->say, port);
    }
    const bool firing_read = (self->shed < (uint8_t)SD_SHED_FIRINGS) && step_misfire(self, page, port, tooth);
    const bool burdened = firing_read || skipped; /* a tooth has one burden beside its own position */
    const bool catches_up = (self->shed < (uint8_t)SD_SHED_MIXTURE) &&
                            sd_fixed_mixture_tooth(&self->mixture, page, tooth, burdened ? 0u : SD_MIXTURE_STEPS);
    if (!burdened && !catches_up) { sd_ecu_do_piece(self, page, port); }
}

/* ---- beside teeth ---------------------------------------------------------------------------------------------- */

void sd_ecu_spurious(sd_ecu_t *self, const sd_calibration_t *page) {
    if (self->shed < (uint8_t)SD_SHED_FIRINGS) { sd_fixed_misfire_spurious(&self->misfire, page); }
}

void sd_ecu_lose_angle(sd_ecu_t *self, uint16_t why) {
    sd_course_lose(&self->course);
    sd_fixed_mixture_restart(&self->mixture);
    self->say.signals.torque_mass_nm = 0.0f;
    sd_publish_worst_of(&self->say, SD_OWNER_TORQUE, SD_INVALID, why);
}

/* A block that followed no teeth for a while starts afresh. */
void sd_ecu_shed(sd_ecu_t *self, uint8_t level) {
    const uint8_t before = self->shed;
    self->shed = level;
    if ((before < (uint8_t)SD_SHED_MIXTURE) != (level < (uint8_t)SD_SHED_MIXTURE)) { sd_fixed_mixture_restart(&self->mixture); }
    if ((before < (uint8_t)SD_SHED_FIRINGS) != (level < (uint8_t)SD_SHED_FIRINGS)) {
        sd_fixed_misfire_restart(&self->misfire);
        sd_publish_judge(&self->say, SD_OWNER_MISFIRE, &self->misfire.status);
    }
    if (level >= (uint8_t)SD_SHED_FIRINGS) { sd_publish_worst_of(&self->say, SD_OWNER_MISFIRE, SD_INVALID, SD_WHY_OVERLOAD); }
}

void sd_ecu_sample(sd_ecu_t *self, sd_input_t input, float value) {
    if (input == SD_INPUT_EXHAUST_LAMBDA) {
        sd_fixed_mixture_sample(&self->mixture, value, self->working.afr_stoichiometric);
    } else if (input == SD_INPUT_EXHAUST_PRESSURE) {
        sd_fixed_mixture_pressure(&self->mixture, value);
    }
}

/* ---- parameters ------------------------------------------------------------------------------------------------ */

/* Trims read theirs once a cycle, as does the torque of each cylinder; what is not built refuses. */
sd_result_t sd_ecu_apply(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index) {
    switch (sd_parameter_infos[index].owner) {
    case SD_OWNER_CRANK:   return sd_crank_set_stall(&self->crank, sd_calibration_crank(page, &self->working).stall_ticks);
    case SD_OWNER_TORQUE:  return (index == SD_PARAMETER_INDEX(torque_edge_sd_deg)) ? SD_OK : init_torque(self, page);
    case SD_OWNER_AFR:     return sd_fixed_mixture_init(&self->mixture, page, &self->working);
    case SD_OWNER_MISFIRE: return sd_fixed_misfire_init(&self->misfire, page, &self->working);
    case SD_OWNER_BALANCE: return SD_OK;
    case SD_OWNER_AIRPATH: return sd_stage_airpath_configure_q31(&self->airpath, page, &self->working);
    default:               return SD_ERR_CONFIG;
    }
}

/* The driveline's observers are in single precision. */
void sd_ecu_wheel(sd_ecu_t *self, const sd_calibration_t *page, uint16_t wheel, uint32_t tick) {
    (void)self, (void)page, (void)wheel, (void)tick;
}

void sd_ecu_task_begin(sd_ecu_t *self, const sd_calibration_t *page, uint32_t tick) {
    self->task_tick = tick;
    self->airpath_crank = sd_say_crank_now(&self->say, page->cylinders);
}

void sd_ecu_task_work(sd_ecu_t *self, const sd_calibration_t *page) {
    if (page->airpath_q31.present == 0u) { return; }
    sd_stage_airpath_step_q31(&self->airpath, page, &self->inputs, &self->airpath_crank, self->task_tick, &self->airpath_out);
}

void sd_ecu_task_say(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, uint16_t why) {
    if (page->airpath_q31.present != 0u) { sd_say_airpath(&self->say, port, self->task_tick, &self->airpath_out, why); }
}
