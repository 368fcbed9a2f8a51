/* SPDX-License-Identifier: MIT */
#include "sd_ecu.h"
#include "sd_ecu_afr.h"

#include <string.h>

#include "sd_ecu_parts.h"

#define RPM_PER_RADPS 9.5492966f
#define TINY 1e-30f
#define NUMBER_MAX 1e9f
#define RAD_PER_DEG 0.017453293f
#define TIMER_SD_TICKS 0.28867513f /* of rounding down to a whole tick: 1 / sqrt(12) */

static bool fixed_point(const sd_ecu_t *self) { return self->calibration.parameters.torque_fixed_point > 0.5f; }

/* ---- the torque observer in either number type ----------------------------------------------------------------- */

static float torque_step(sd_ecu_t *self, const sd_tooth_t *tooth) {
    const uint8_t trusted = (tooth->health == SD_VALID) ? 1u : 0u;
    const sd_fourier_tables_t *tables = &self->calibration.fourier;
    return fixed_point(self) ? sd_fourier_step_q31(&self->torque.q31, tables, tooth->cycle_position, tooth->advance,
                                                   tooth->period_ticks, trusted)
                             : sd_fourier_step_f32(&self->torque.f32, tables, tooth->cycle_position, tooth->advance,
                                                   tooth->period_ticks, trusted);
}

static void torque_restart(sd_ecu_t *self) {
    if (fixed_point(self)) { sd_fourier_restart_q31(&self->torque.q31); } else { sd_fourier_restart_f32(&self->torque.f32); }
}

static void torque_shift(sd_ecu_t *self) {
    if (fixed_point(self)) {
        sd_fourier_shift_revolution_q31(&self->torque.q31);
    } else {
        sd_fourier_shift_revolution_f32(&self->torque.f32);
    }
}

static sd_status_t torque_status(const sd_ecu_t *self) {
    return fixed_point(self) ? sd_fourier_status_q31(&self->torque.q31) : sd_fourier_status_f32(&self->torque.f32);
}

static sd_fourier_estimate_t torque_estimate(const sd_ecu_t *self) {
    sd_fourier_estimate_t estimate;
    if (fixed_point(self)) { sd_fourier_read_q31(&self->torque.q31, &estimate); } else { sd_fourier_read_f32(&self->torque.f32, &estimate); }
    return estimate;
}

/* A right checksum is no proof of right numbers. What the blocks do not check themselves: */

static bool within(float x, float low, float high) { return (x >= low) && (x <= high); } /* false for NaN */

static bool map_ok(const sd_calibration_t *calibration) {
    const sd_cylinder_map_t *map = &calibration->cylinder_map;
    bool ok = ((map->cylinders == 0u) || (map->cylinders == calibration->cylinders)) && (map->harmonics <= SD_FOURIER_HARMONICS_MAX);
    for (uint32_t i = 0; ok && (i < map->cylinders); ++i) {
        ok = within(map->offset_nm[i], -NUMBER_MAX, NUMBER_MAX) && within(map->nm_per_bar[i], -NUMBER_MAX, NUMBER_MAX) &&
             within(map->sd_kgm2[i], 0.0f, NUMBER_MAX);
        for (uint32_t j = 0; ok && (j <= 2u * map->harmonics); ++j) { ok = within(map->map[i][j], -NUMBER_MAX, NUMBER_MAX); }
    }
    return ok;
}

static bool cylinders_ok(const sd_calibration_t *calibration) {
    bool ok = (calibration->cylinders >= 1u) && (calibration->cylinders <= SD_CYLINDERS_MAX) && map_ok(calibration);
    for (uint32_t i = 0; ok && (i < calibration->cylinders); ++i) {
        ok = (calibration->firing_order[i] >= 1u) && (calibration->firing_order[i] <= SD_CYLINDERS_MAX) &&
             (calibration->firing_position[i] < 2u * calibration->positions);
    }
    return ok;
}

static bool page_ok(const sd_calibration_t *calibration) {
    const float *parameter = (const float *)&calibration->parameters;
    bool ok = within(calibration->position_0_deg, 0.0f, 360.0f) && within(calibration->tick_hz, 1e5f, 2e8f) && cylinders_ok(calibration);
    for (uint32_t i = 0; ok && (i < SD_PARAMETER_COUNT); ++i) {
        ok = within(parameter[i], sd_parameter_infos[i].low, sd_parameter_infos[i].high);
    }
    return ok;
}

sd_result_t sd_ecu_init(sd_ecu_t *self, const sd_calibration_t *calibration) {
    if (!page_ok(calibration)) { return SD_ERR_CONFIG; }
    const sd_crank_config_t crank_config = sd_calibration_crank(calibration);
    const sd_fourier_config_t torque_config = sd_calibration_torque(calibration);
    sd_crank_t crank;
    sd_torque_t torque;
    sd_misfire_t misfire;
    sd_afr_t afr;
    sd_afr_delay_t afr_delay;
    sd_balance_t balance;
    const sd_misfire_config_t misfire_config = sd_calibration_misfire(calibration);
    if (sd_crank_init(&crank, &crank_config) != SD_OK) { return SD_ERR_CONFIG; }
    const sd_result_t result = (calibration->parameters.torque_fixed_point > 0.5f)
                                   ? sd_fourier_init_q31(&torque.q31, &torque_config, &calibration->fourier)
                                   : sd_fourier_init_f32(&torque.f32, &torque_config, &calibration->fourier);
    if (result != SD_OK) { return result; }
    if (sd_misfire_init(&misfire, &misfire_config) != SD_OK) { return SD_ERR_CONFIG; }
    const bool has_filter = calibration->kalman.positions != 0u;
    if (has_filter && (calibration->kalman.positions != calibration->positions)) { return SD_ERR_CONFIG; }
    const sd_firings_config_t firings_config = sd_ecu_firings_config(calibration);
    sd_firings_t firings;
    if (sd_firings_init(&firings, &firings_config, &calibration->kalman) != SD_OK) { return SD_ERR_CONFIG; }
    if ((sd_ecu_afr_init(&afr, calibration) != SD_OK) || (sd_ecu_delay_init(&afr_delay, calibration) != SD_OK) ||
        (sd_ecu_balance_init(&balance, calibration) != SD_OK)) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self); /* from here on nothing fails; the struct is too large to be built aside */
    for (uint32_t owner = 0; owner < SD_OWNER_COUNT; ++owner) {
        self->status[owner] = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_NO_SYNC };
    }
    self->calibration = *calibration;
    self->reference = calibration->parameters;
    self->crank = crank;
    self->torque = torque;
    self->misfire = misfire;
    self->afr = afr;
    self->afr_delay = afr_delay;
    self->balance = balance;
    self->firings = firings;
    return SD_OK;
}

/* ---- signals --------------------------------------------------------------------------------------------------- */

void sd_ecu_publish(sd_ecu_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate) {
    const float *value = (const float *)&self->signals;
    for (uint32_t channel = 0; channel < SD_SIGNAL_COUNT; ++channel) {
        const sd_signal_info_t *info = &sd_signal_infos[channel];
        if (info->rate != (uint8_t)rate) { continue; }
        const sd_status_t *status = &self->status[info->owner];
        sd_event_t event = { .tick = tick, .kind = SD_EVENT_SIGNAL, .channel = (uint16_t)channel,
                             .flags = status->health | ((uint32_t)status->why << 8) };
        memcpy(&event.value, &value[channel], sizeof event.value);
        self->unsent_signals += 1u - port->send(port->context, &event, 1u);
    }
}

_Static_assert(sizeof(sd_signals_t) == SD_SIGNAL_COUNT * sizeof(float), "signals are floats, without gaps");

void sd_ecu_worst_of(sd_status_t *status, uint8_t health, uint16_t why) {
    if (health > status->health) { status->health = health; }
    status->why |= why;
}

/* ---- the cycle ------------------------------------------------------------------------------------------------- */

static void begin_cycle(sd_ecu_t *self) {
    self->cycle_ticks = 0;
    self->cycle_positions = 0;
    self->cycle_clean = 1;
}

/* Torque of each cylinder by its physical number, from the cycle just ended and its mean speed. */
static void read_cylinders(sd_ecu_t *self) {
    const sd_calibration_t *c = &self->calibration;
    const sd_cylinder_map_t *map = &c->cylinder_map;
    const sd_fourier_config_t observer = sd_calibration_torque(c);
    if (!sd_cylinders_fit(map, &observer)) {
        sd_ecu_worst_of(&self->status[SD_OWNER_CYLINDER], SD_INVALID, SD_WHY_UNCALIBRATED);
        return;
    }
    const float speed = self->signals.cycle_speed_rpm / RPM_PER_RADPS;
    const float spacing = c->parameters.torque_tooth_sd_deg * RAD_PER_DEG, timer = speed * TIMER_SD_TICKS / c->tick_hz;
    const float variance = spacing * spacing + timer * timer;
    const float tooth_error = variance * sd_rsqrt_f32(variance + TINY);
    const sd_sample_t *intake = &self->sample[SD_INPUT_AIR_INTAKE_PRESSURE];
    if (intake->seen == 0u) { sd_ecu_worst_of(&self->status[SD_OWNER_CYLINDER], SD_DEGRADED, SD_WHY_NO_INPUT); }
    const float intake_bar = (intake->seen != 0u) ? intake->value : 1.0f;
    const sd_fourier_estimate_t estimate = torque_estimate(self);
    for (uint32_t i = 0; i < map->cylinders; ++i) {
        const uint32_t cylinder = c->firing_order[i] - 1u;
        self->signals.cycle_cylinder_torque_nm[cylinder] = sd_cylinders_torque(map, &estimate, intake_bar, i);
        self->signals.cycle_cylinder_sd_nm[cylinder] = sd_cylinders_sd(map, i, speed, tooth_error);
    }
}

static void end_cycle(sd_ecu_t *self, const sd_port_t *port, uint32_t tick) {
    const sd_calibration_t *c = &self->calibration;
    sd_status_t *status = &self->status[SD_OWNER_CYLINDER];
    *status = self->status[SD_OWNER_TORQUE];
    if (self->crank.phase_votes < 2u) { sd_ecu_worst_of(status, SD_INVALID, SD_WHY_NO_PHASE); }
    if (self->cycle_positions < 2u * c->positions) { sd_ecu_worst_of(status, SD_INVALID, SD_WHY_NO_SYNC); }
    if (self->cycle_clean == 0u) { sd_ecu_worst_of(status, SD_DEGRADED, SD_WHY_FAULT); }
    const float turns = (float)self->cycle_positions / (float)c->positions;
    self->signals.cycle_speed_rpm = (self->cycle_ticks > 0u) ? 60.0f * turns * c->tick_hz / (float)self->cycle_ticks : 0.0f;
    read_cylinders(self);
    sd_ecu_afr_cycle(self);
    sd_ecu_publish(self, port, tick, SD_RATE_CYCLE);
}

static void add_to_cycle(sd_ecu_t *self, const sd_tooth_t *tooth) {
    self->cycle_ticks += tooth->period_ticks;
    self->cycle_positions += tooth->advance;
    /* What is read at its end has settled by then, or says so itself. */
    const sd_status_t *torque = &self->status[SD_OWNER_TORQUE];
    if ((torque->health == (uint8_t)SD_INVALID) || ((torque->why & (uint16_t)~SD_WHY_CONVERGING) != 0u)) { self->cycle_clean = 0; }
}

/* ---- events ---------------------------------------------------------------------------------------------------- */

/* Keeps the observer's angle the decoder's: half a cycle off is a matter of sign, anything else a fresh start. */
static void follow(sd_ecu_t *self, const sd_tooth_t *tooth) {
    const uint32_t cycle = 2u * self->calibration.positions;
    const uint32_t expected = (self->cycle_position + (uint32_t)tooth->advance) % cycle;
    const uint32_t off = (tooth->cycle_position + cycle - expected) % cycle;
    if ((self->following == 0u) || ((off != 0u) && (off != self->calibration.positions))) {
        torque_restart(self);
        sd_ecu_firing_restart(self);
        sd_ecu_afr_restart(self);
        begin_cycle(self);
    } else if (off != 0u) {
        torque_shift(self);
        sd_ecu_firing_restart(self);
        sd_ecu_afr_restart(self);
        begin_cycle(self);
    }
    self->following = 1;
}

static void on_tooth(sd_ecu_t *self, const sd_port_t *port, const sd_tooth_t *tooth) {
    follow(self, tooth);
    if (tooth->cycle_position < self->cycle_position) {
        end_cycle(self, port, tooth->tick);
        begin_cycle(self);
    }
    self->signals.torque_mass_nm = torque_step(self, tooth);
    self->cycle_position = tooth->cycle_position;
    sd_status_t *status = &self->status[SD_OWNER_TORQUE];
    *status = torque_status(self);
    sd_ecu_worst_of(status, tooth->health, tooth->why);
    self->signals.torque_innovation_j = status->innovation;
    add_to_cycle(self, tooth);
    sd_ecu_firing_tooth(self, port, tooth);
    sd_ecu_afr_tooth(self, tooth);
}

static void lose_angle(sd_ecu_t *self, uint16_t why) {
    self->following = 0;
    sd_ecu_afr_restart(self);
    self->signals.torque_mass_nm = 0.0f;
    sd_ecu_worst_of(&self->status[SD_OWNER_TORQUE], SD_INVALID, why);
    sd_ecu_worst_of(&self->status[SD_OWNER_FIRING], SD_INVALID, why);
}

static void on_crank_edge(sd_ecu_t *self, const sd_port_t *port, uint32_t tick) {
    sd_tooth_t tooth;
    sd_crank_edge(&self->crank, tick, &tooth);
    const sd_calibration_t *c = &self->calibration;
    sd_signals_t *s = &self->signals;
    self->status[SD_OWNER_CRANK] = (sd_status_t){ .health = tooth.health, .why = tooth.why };
    s->crank_edge_class = (float)tooth.edge_class;
    s->crank_tooth = (float)tooth.position;
    const float angle_deg = c->position_0_deg + (float)tooth.cycle_position * (360.0f / (float)c->positions);
    s->crank_angle_deg = (angle_deg >= 720.0f) ? angle_deg - 720.0f : angle_deg;
    s->crank_phase_known = (float)tooth.phase_known;
    if (tooth.period_ticks > 0u) {
        s->crank_speed_rpm = sd_crank_speed_radps(&self->crank, &tooth, c->tick_hz) * RPM_PER_RADPS;
        s->crank_acceleration_radps2 = sd_crank_acceleration_radps2(&self->crank, &tooth, c->tick_hz);
    }
    if (tooth.edge_class == SD_EDGE_UNSYNCED) {
        lose_angle(self, SD_WHY_NO_SYNC);
    } else if (tooth.edge_class != SD_EDGE_SPURIOUS) {
        on_tooth(self, port, &tooth);
    } else {
        sd_ecu_firing_spurious(self);
    }
    sd_ecu_publish(self, port, tick, SD_RATE_EDGE);
}

static void publish_lost_angle(sd_ecu_t *self, const sd_port_t *port, uint32_t tick, uint16_t why) {
    lose_angle(self, why);
    self->status[SD_OWNER_CRANK] = (sd_status_t){ .health = SD_INVALID, .why = why };
    self->signals.crank_edge_class = (float)SD_EDGE_UNSYNCED;
    self->signals.crank_phase_known = 0.0f;
    self->signals.crank_speed_rpm = 0.0f;
    self->signals.crank_acceleration_radps2 = 0.0f;
    sd_ecu_publish(self, port, tick, SD_RATE_EDGE);
}

static void on_sample(sd_ecu_t *self, const sd_event_t *event) {
    float value = 0.0f;
    memcpy(&value, &event->value, sizeof value);
    const sd_signal_info_t *info = (event->channel < SD_INPUT_COUNT) ? &sd_input_infos[event->channel] : NULL;
    if ((info == NULL) || !((value >= info->low) && (value <= info->high))) { /* written so that NaN is out of range */
        self->bad_samples++;
        return;
    }
    if (event->channel == SD_INPUT_EXHAUST_LAMBDA) { sd_ecu_afr_sample(self, value); }
    self->sample[event->channel] = (sd_sample_t){ .value = value, .tick = event->tick, .seen = 1 };
}

static void on_time(sd_ecu_t *self, const sd_port_t *port, uint32_t tick) {
    if (sd_crank_poll(&self->crank, tick)) { publish_lost_angle(self, port, tick, SD_WHY_STALL); }
    const sd_event_t done = { .tick = tick, .kind = SD_EVENT_DONE, .value = self->unsent_signals, .flags = self->unknown_events };
    (void)port->send(port->context, &done, 1u);
}

/* The decoder would take lost edges for a mark or a change of speed, so it starts afresh. */
static void on_gap(sd_ecu_t *self, const sd_port_t *port, uint32_t tick) {
    sd_crank_lose_sync(&self->crank);
    publish_lost_angle(self, port, tick, SD_WHY_NO_SYNC);
}

/* ---- the loop -------------------------------------------------------------------------------------------------- */

uint32_t sd_ecu_run(sd_ecu_t *self, const sd_port_t *port) {
    sd_event_t event;
    uint32_t handled = 0;
    while (port->receive(port->context, &event, 1u) == 1u) {
        switch (event.kind) {
        case SD_EVENT_CRANK_EDGE: on_crank_edge(self, port, event.tick); break;
        case SD_EVENT_CAM_EDGE:   sd_crank_cam_edge(&self->crank, event.tick); break;
        case SD_EVENT_TIME:       on_time(self, port, event.tick); break;
        case SD_EVENT_SAMPLE:     on_sample(self, &event); break;
        case SD_EVENT_GAP:        on_gap(self, port, event.tick); break;
        case SD_EVENT_PARAMETER:  sd_ecu_parameter(self, port, &event); break;
        default:                  self->unknown_events++; break;
        }
        handled++;
    }
    return handled;
}
