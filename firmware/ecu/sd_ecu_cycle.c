/* SPDX-License-Identifier: MIT */
/* What the end of a cycle leaves to do, one piece a tooth, counted in teeth: the same on every port and target, and no tooth
 * costs much more than another. */
#include <string.h>

#include "sd_ecu_parts.h"
#include "sd_say.h"
#include "sd_math.h"

#define STEADY_SPEED 0.02f /* share by which a cycle may differ from the last and still be steady */
#define STEADY_FUEL  0.05f

static float changed(float now, float before) {
    const float step = (now > before) ? now - before : before - now;
    return (before > 0.0f) ? step / before : 1.0f;
}

/* What has not burned is no mixture to be trimmed, or to be learned from. */
static bool is_steady(sd_ecu_t *self) {
    const float speed = self->work.cycle.speed_radps, fuel_mg = sd_inputs_value(&self->inputs, SD_INPUT_FUEL_INJECTED);
    const bool moves = (changed(speed, self->last_speed_radps) > STEADY_SPEED) || (changed(fuel_mg, self->last_fuel_mg) > STEADY_FUEL);
    self->last_speed_radps = speed;
    self->last_fuel_mg = fuel_mg;
    return !moves && (fuel_mg > 0.0f) && (self->trims.ended.misfired == 0u);
}

static sd_trims_wish_t wish_of(const sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_input_t enable = SD_INPUT_BALANCE_ENABLE;
    if ((self->working.balance_source < 0.5f) || (page->cylinders < 2u)) { return SD_TRIMS_OFF; }
    if (sd_inputs_fresh(&self->inputs, enable)) {
        return (sd_inputs_value(&self->inputs, enable) > 0.5f) ? SD_TRIMS_LEARN : SD_TRIMS_OFF;
    }
    return (self->trims_wanted != 0u) ? SD_TRIMS_FREEZE : SD_TRIMS_OFF;
}

/* ---- the pieces ------------------------------------------------------------------------------------------------ */

static void read_cylinders(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_cycle_t *cycle = &self->work.cycle;
    sd_status_t status = self->work.torque;
    sd_cylinders_out_t cylinders;
    sd_stage_torque_cylinders(&self->torque, page, &self->working, cycle->speed_radps,
                              sd_inputs_value(&self->inputs, SD_INPUT_AIR_INTAKE_PRESSURE), &cylinders);
    if (!cycle->phase_known) { sd_status_worst_of(&status, SD_INVALID, SD_WHY_NO_PHASE); }
    if (!cycle->whole) { sd_status_worst_of(&status, SD_INVALID, SD_WHY_NO_SYNC); }
    if (!cycle->clean) { sd_status_worst_of(&status, SD_DEGRADED, SD_WHY_FAULT); }
    if (cylinders.known == 0u) {
        sd_status_worst_of(&status, SD_INVALID, SD_WHY_UNCALIBRATED);
    } else {
        sd_inputs_judge(&self->inputs, SD_OWNER_CYLINDER, &status);
        sd_say_cylinders(&self->say, page, &cylinders);
    }
    sd_publish_judge(&self->say, SD_OWNER_CYLINDER, &status);
}

static void learn_delay(sd_ecu_t *self, const sd_calibration_t *page) {
    self->work.steady = is_steady(self) ? 1u : 0u;
    const sd_mixture_cycle_t cycle = { .speed_radps = self->work.cycle.speed_radps,
                                       .steady = (self->work.steady != 0u) && self->work.cycle.phase_known,
                                       .trimming = wish_of(self, page) == SD_TRIMS_LEARN,
                                       .diverged = self->trims.balance.diverged != 0u,
                                       .trims_learned = self->trims.balance.learned,
                                       .trim = self->trims.trim };
    if (sd_stage_mixture_learn(&self->mixture, &self->working, &cycle)) { sd_balance_resume(&self->trims.balance); }
}

/* Without a pressure the manifold's model runs alone, which is well unless there was one. */
static void judge_pressure(const sd_ecu_t *self, sd_status_t *status) {
    const bool lost = sd_inputs_fell_silent(&self->inputs, SD_INPUT_EXHAUST_PRESSURE);
    if (lost && sd_stage_mixture_takes_pressure(&self->mixture)) { sd_status_worst_of(status, SD_DEGRADED, SD_WHY_STALE_INPUT); }
}

static void read_mixture(sd_ecu_t *self, const sd_calibration_t *page) {
    sd_mixture_out_t *out = &self->work.mixture;
    const sd_inputs_t *inputs = &self->inputs;
    sd_afr_conditions_t at = { .speed_radps = self->work.cycle.speed_radps,
                               .intake_bar = sd_inputs_value(inputs, SD_INPUT_AIR_INTAKE_PRESSURE),
                               .fuel_mg = sd_inputs_value(inputs, SD_INPUT_FUEL_INJECTED),
                               .exhaust_k = sd_inputs_value_or_0(inputs, SD_INPUT_EXHAUST_TEMPERATURE),
                               .vanes = sd_inputs_value_or_0(inputs, SD_INPUT_EXHAUST_VANES),
                               .turbine_rpm = sd_inputs_value_or_0(inputs, SD_INPUT_EXHAUST_TURBINE_SPEED) };
    const sd_mixture_egr_t egr = { .at = &at, .stoichiometric = self->working.afr_stoichiometric,
                                   .air_gps = sd_inputs_value_or_0(inputs, SD_INPUT_AIR_FLOW),
                                   .opening = sd_inputs_value_or_0(inputs, SD_INPUT_EGR_POSITION) };
    at.egr_share = sd_stage_mixture_recirculated(&self->mixture, page, &egr);
    sd_stage_mixture_read(&self->mixture, &at, out);
    judge_pressure(self, &out->status);
    if (!self->work.cycle.phase_known) { sd_status_worst_of(&out->status, SD_INVALID, SD_WHY_NO_PHASE); }
    if ((out->status.why & (uint32_t)SD_WHY_UNCALIBRATED) == 0u) { sd_inputs_judge(&self->inputs, SD_OWNER_AFR, &out->status); }
    out->deviations.health = out->status.health;
    sd_say_mixture(&self->say, page, out, &self->mixture);
}

static void begin_trims(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_trims_wish_t wish = wish_of(self, page);
    sd_deviations_t by_torque;
    const bool from_torque = self->working.balance_source > 1.5f;
    if (from_torque) { sd_stage_trims_by_torque(&self->trims, page->cylinders, &by_torque); }
    const bool transient = (self->work.steady == 0u) || (self->mixture.delay.probed != 0u);
    sd_stage_trims_begin(&self->trims, wish, from_torque ? &by_torque : &self->work.mixture.deviations, transient);
    self->trims_wanted = (wish != SD_TRIMS_OFF) ? 1u : 0u;
}

static void command_trims(sd_ecu_t *self, const sd_calibration_t *page) {
    float probe[SD_BALANCE_CYLINDERS_MAX];
    sd_stage_mixture_probe(&self->mixture, self->working.afr_delay_probe, probe);
    sd_stage_trims_command(&self->trims, probe, self->working.balance_trim_limit);
    sd_status_t status = sd_balance_status(&self->trims.balance);
    sd_inputs_judge(&self->inputs, SD_OWNER_BALANCE, &status);
    sd_publish_judge(&self->say, SD_OWNER_BALANCE, &status);
    sd_say_trims(&self->say, page, &self->trims);
}

/* True when the row is complete. */
static bool say_part(sd_ecu_t *self, const sd_port_t *port) {
    self->work.said = (uint16_t)sd_publish_part(&self->say, port, self->work.cycle.tick, SD_RATE_CYCLE, self->work.said);
    return self->work.said == 0u;
}

/* ---- their order ----------------------------------------------------------------------------------------------- */

void sd_ecu_do_piece(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port) {
    bool done = true;
    switch ((sd_piece_t)self->work.piece) {
    case SD_PIECE_CYLINDERS: read_cylinders(self, page); break;
    case SD_PIECE_DELAY:     learn_delay(self, page); break;
    case SD_PIECE_MIXTURE:   read_mixture(self, page); break;
    case SD_PIECE_TRIMS:     begin_trims(self, page); break;
    case SD_PIECE_BALANCE:   done = !sd_stage_trims_work(&self->trims); break;
    case SD_PIECE_COMMAND:   command_trims(self, page); break;
    case SD_PIECE_MISFIRES:  sd_say_misfires(&self->say, page, &self->misfire.monitor); break;
    case SD_PIECE_SAY:       done = say_part(self, port); break;
    case SD_PIECE_POINT:     done = !sd_stage_mixture_work(&self->mixture, page); break;
    default:                 return; /* nothing is due */
    }
    if (done) { self->work.piece++; }
}

void sd_ecu_begin_work(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_cycle_t *cycle) {
    const bool all = self->shed == (uint8_t)SD_SHED_NONE;
    while (all && (self->work.piece < (uint8_t)SD_PIECE_NONE)) { sd_ecu_do_piece(self, page, port); }
    if (self->work.piece < (uint8_t)SD_PIECE_NONE) { return; } /* what is under way goes on, one piece a tooth */
    self->work.cycle = *cycle;
    self->work.torque = sd_publish_judged(&self->say, SD_OWNER_TORQUE);
    self->work.said = 0;
    self->work.piece = all ? SD_PIECE_CYLINDERS : SD_PIECE_SAY;
    if (!all) { sd_ecu_say_cycle_shed(&self->say); }
    self->say.signals.cycle_speed_rpm = cycle->speed_radps * SD_RPM_PER_RADPS;
}
