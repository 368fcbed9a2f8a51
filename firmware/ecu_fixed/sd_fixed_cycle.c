/* SPDX-License-Identifier: MIT */
/* What the end of a cycle leaves to do in an ecu of fixed point, one piece a tooth: sd_ecu_cycle.c says why. */
#include "sd_ecu_parts.h"
#include "sd_fixed_parts.h"
#include "sd_math.h"

#define STEADY_SPEED 0.02f /* share by which a cycle may differ from the last and still be steady */
#define STEADY_FUEL  0.05f
#define TIMER_SD_TICKS 0.28867513f /* of rounding down to a whole tick: 1 / sqrt(12) */

static bool changed(float now, float before, float share) {
    const sd_scaled_t a = sd_scaled_of(now), b = sd_scaled_of(before), step = sd_scaled_sub(a, b);
    const sd_scaled_t size = (step.mantissa < 0) ? sd_scaled_neg(step) : step;
    return (b.mantissa <= 0) || sd_scaled_less(sd_scaled_mul(sd_scaled_of(share), b), size);
}

static bool is_steady(sd_ecu_t *self) {
    const float speed = self->work.cycle.speed_radps, fuel_mg = sd_inputs_value(&self->inputs, SD_INPUT_FUEL_INJECTED);
    const bool moves = changed(speed, self->last_speed_radps, STEADY_SPEED) || changed(fuel_mg, self->last_fuel_mg, STEADY_FUEL);
    self->last_speed_radps = speed;
    self->last_fuel_mg = fuel_mg;
    const bool burned = self->misfired == 0u; /* what has not burned is no mixture to be trimmed */
    self->misfired = 0;
    return !moves && burned && (sd_bits_order(fuel_mg) > 0);
}

static bool above_half(float x) { return sd_bits_order(x) > sd_bits_order(0.5f); }

static sd_trims_wish_t wish_of(const sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_input_t enable = SD_INPUT_BALANCE_ENABLE;
    if (!above_half(self->working.balance_source) || (page->cylinders < 2u)) { return SD_TRIMS_OFF; }
    if (sd_inputs_fresh(&self->inputs, enable)) {
        return above_half(sd_inputs_value(&self->inputs, enable)) ? SD_TRIMS_LEARN : SD_TRIMS_OFF;
    }
    return (self->trims_wanted != 0u) ? SD_TRIMS_FREEZE : SD_TRIMS_OFF;
}

/* ---- the pieces ------------------------------------------------------------------------------------------------ */

static bool same(float a, float b) { return sd_bits_of(a) == sd_bits_of(b); }

/* As sd_cylinders_fit. */
static bool map_fits(const sd_cylinder_map_t *map, const sd_parameters_t *p) {
    return (map->cylinders > 0u) && (map->harmonics == sd_scaled_floor(sd_scaled_of(p->torque_harmonics))) &&
           same(map->gain_energy, p->torque_gain_energy_per_rad) && same(map->gain_mean, p->torque_gain_mean_per_rad2) &&
           same(map->gain_reference, p->torque_gain_reference_per_rad2);
}

static void judge_cylinders(sd_ecu_t *self, bool known) {
    const sd_cycle_t *cycle = &self->work.cycle;
    sd_status_t status = self->work.torque;
    if (!cycle->phase_known) { sd_status_worst_of(&status, SD_INVALID, SD_WHY_NO_PHASE); }
    if (!cycle->whole) { sd_status_worst_of(&status, SD_INVALID, SD_WHY_NO_SYNC); }
    if (!cycle->clean) { sd_status_worst_of(&status, SD_DEGRADED, SD_WHY_FAULT); }
    if (!known) {
        sd_status_worst_of(&status, SD_INVALID, SD_WHY_UNCALIBRATED);
    } else {
        sd_inputs_judge(&self->inputs, SD_OWNER_CYLINDER, &status);
    }
    sd_publish_judge(&self->say, SD_OWNER_CYLINDER, &status);
    sd_fourier_read_q31(&self->torque_ended, &self->ended);
}

/* Torque of one cylinder and its deviation: sd_cylinders.h in scaled integers. True when it was the last one. */
static bool read_cylinder(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_cylinder_map_t *map = &page->cylinder_map;
    const uint32_t i = self->work.part;
    const bool known = map_fits(map, &self->working);
    if (i == 0u) { judge_cylinders(self, known); }
    if (!known) { return true; }
    const sd_scaled_t bar = sd_scaled_of(sd_inputs_value(&self->inputs, SD_INPUT_AIR_INTAKE_PRESSURE));
    const sd_scaled_t speed = sd_scaled_of(self->work.cycle.speed_radps);
    sd_scaled_t torque = sd_scaled_add(sd_scaled_of(map->offset_nm[i]), sd_scaled_mul(sd_scaled_of(map->nm_per_bar[i]), bar));
    for (uint32_t j = 0; j <= 2u * map->harmonics; ++j) {
        torque = sd_scaled_add(torque, sd_scaled_mul(sd_scaled_of(map->map[i][j]), sd_scaled_of(self->ended.coefficient_nm[j])));
    }
    const sd_scaled_t spacing = sd_scaled_mul(sd_scaled_of(self->working.torque_edge_sd_deg), sd_scaled_of(SD_RAD_PER_DEG));
    const sd_scaled_t timer = sd_scaled_div(sd_scaled_mul(speed, sd_scaled_of(TIMER_SD_TICKS)), sd_scaled_of(page->tick_hz));
    const sd_scaled_t error = sd_scaled_root(sd_scaled_add(sd_scaled_mul(spacing, spacing), sd_scaled_mul(timer, timer)));
    const sd_scaled_t sd = sd_scaled_mul(sd_scaled_mul(sd_scaled_mul(sd_scaled_of(map->sd_kgm2[i]), speed), speed), error);
    const uint32_t physical = page->firing_order[i] - 1u;
    self->say.signals.cycle_cylinder_torque_nm[physical] = sd_scaled_to_float(torque);
    self->say.signals.cycle_cylinder_sd_nm[physical] = sd_scaled_to_float(sd);
    self->work.part++;
    if (self->work.part < map->cylinders) { return false; }
    return true;
}

static void read_mixture(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_inputs_t *inputs = &self->inputs;
    sd_status_t *status = &self->work.mixture_status;
    const sd_afr_conditions_t at = { .speed_radps = self->work.cycle.speed_radps,
                                     .intake_bar = sd_inputs_value(inputs, SD_INPUT_AIR_INTAKE_PRESSURE),
                                     .fuel_mg = sd_inputs_value(inputs, SD_INPUT_FUEL_INJECTED),
                                     .exhaust_k = sd_inputs_value_or_0(inputs, SD_INPUT_EXHAUST_TEMPERATURE),
                                     .vanes = sd_inputs_value_or_0(inputs, SD_INPUT_EXHAUST_VANES),
                                     .turbine_rpm = sd_inputs_value_or_0(inputs, SD_INPUT_EXHAUST_TURBINE_SPEED) };
    self->work.steady = is_steady(self) ? 1u : 0u;
    sd_fixed_mixture_read(&self->mixture, &at, &self->work.mixture, status);
    if (sd_inputs_fell_silent(inputs, SD_INPUT_EXHAUST_PRESSURE) && sd_fixed_mixture_takes_pressure(&self->mixture)) {
        sd_status_worst_of(status, SD_DEGRADED, SD_WHY_STALE_INPUT);
    }
    if (!self->work.cycle.phase_known) { sd_status_worst_of(status, SD_INVALID, SD_WHY_NO_PHASE); }
    const uint32_t none = (uint32_t)SD_WHY_UNCALIBRATED | (uint32_t)SD_WHY_NOT_BUILT;
    if ((status->why & none) == 0u) { sd_inputs_judge(inputs, SD_OWNER_AFR, status); }
    sd_fixed_say_mixture(self, page);
}

static void move_trims(sd_ecu_t *self, const sd_calibration_t *page) {
    const sd_trims_wish_t wish = wish_of(self, page);
    sd_fixed_trims_cycle(&self->trims, &self->working, page->cylinders, wish, &self->work.mixture, self->work.mixture_status.health,
                         self->work.steady == 0u);
    self->trims_wanted = (wish != SD_TRIMS_OFF) ? 1u : 0u;
    sd_status_t status = sd_fixed_trims_status(&self->trims);
    sd_inputs_judge(&self->inputs, SD_OWNER_BALANCE, &status);
    sd_publish_judge(&self->say, SD_OWNER_BALANCE, &status);
    sd_fixed_say_trims(self, page);
}

/* True when the row is complete. */
static bool say_part(sd_ecu_t *self, const sd_port_t *port) {
    self->work.said = (uint16_t)sd_publish_part(&self->say, port, self->work.cycle.tick, SD_RATE_CYCLE, self->work.said);
    return self->work.said == 0u;
}

/* ---- their order ----------------------------------------------------------------------------------------------- */

void sd_ecu_do_piece(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port) {
    bool done = true;
    switch ((sd_fixed_piece_t)self->work.piece) {
    case SD_FIXED_CYLINDERS: done = read_cylinder(self, page); break;
    case SD_FIXED_MIXTURE:   read_mixture(self, page); break;
    case SD_FIXED_TRIMS:     move_trims(self, page); break;
    case SD_FIXED_SAY:       done = say_part(self, port); break;
    case SD_FIXED_POINT:     done = !sd_fixed_mixture_work(&self->mixture, page, &self->working); break;
    default:                 return; /* nothing is due */
    }
    if (done) { self->work.piece++; }
}

void sd_fixed_begin_work(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_cycle_t *cycle) {
    const bool all = self->shed == (uint8_t)SD_SHED_NONE;
    while (all && (self->work.piece < (uint8_t)SD_FIXED_NONE)) { sd_ecu_do_piece(self, page, port); }
    if (self->work.piece < (uint8_t)SD_FIXED_NONE) { return; } /* what is under way goes on, one piece a tooth */
    self->work.cycle = *cycle;
    self->work.torque = sd_publish_judged(&self->say, SD_OWNER_TORQUE);
    self->work.said = 0;
    self->work.part = 0;
    self->work.piece = all ? SD_FIXED_CYLINDERS : SD_FIXED_SAY;
    if (!all) { sd_ecu_say_cycle_shed(&self->say); }
    self->say.signals.cycle_speed_rpm = sd_scaled_to_float(sd_scaled_mul(sd_scaled_of(cycle->speed_radps), sd_scaled_of(SD_RPM_PER_RADPS)));
}
