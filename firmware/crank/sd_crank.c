/* SPDX-License-Identifier: MIT */
#include "sd_crank.h"

#include <string.h>

#include "sd_crank_parts.h"

enum { PHASE_VOTES = 2 }; /* cam edges that must agree */

_Static_assert(sizeof(sd_crank_t) == 948, "without pointers, the same size on every target");

static bool stall_in_range(uint32_t ticks) { return (ticks >= 256u) && (ticks <= (uint32_t)STALL_TICKS_MAX); }

sd_result_t sd_crank_init(sd_crank_t *self, const sd_crank_config_t *config) {
    const bool in_range = (config->positions >= SD_CRANK_POSITIONS_MIN) && (config->positions <= SD_CRANK_POSITIONS_MAX) &&
                          (config->missing_count >= 1u) && (config->missing_count <= SD_CRANK_MISSING_MAX) &&
                          stall_in_range(config->stall_ticks) &&
                          (config->cam_position < 2u * config->positions);
    if (!in_range) { return SD_ERR_CONFIG; }
    for (uint32_t i = 1; i < config->missing_count; ++i) {
        if (config->missing[i] <= config->missing[i - 1u]) { return SD_ERR_CONFIG; }
    }
    if (config->missing[config->missing_count - 1u] != config->positions - 1u) { return SD_ERR_CONFIG; }
    sd_crank_t fresh;
    memset(&fresh, 0, sizeof fresh);
    fresh.config = *config;
    fresh.pending_mark = SD_CRANK_MARKS_MAX;
    if (!sd_wheel_init(&fresh)) { return SD_ERR_CONFIG; }
    sd_search_begin(&fresh);
    *self = fresh;
    return SD_OK;
}

/* ---- edges ----------------------------------------------------------------------------------------------------- */

static void forget_angle(sd_crank_t *self, uint8_t mode) {
    if (self->mode == SYNCED) { self->counts.sync_losses++; }
    self->mode = mode;
    self->phase_votes = 0;
    self->pending_mark = SD_CRANK_MARKS_MAX;
    sd_wheel_reset_widths(self);
    sd_search_begin(self);
}

static void describe(const sd_crank_t *self, sd_tooth_t *tooth) {
    tooth->position = self->position;
    tooth->phase_known = (self->phase_votes >= PHASE_VOTES) ? 1u : 0u;
    tooth->cycle_position = (uint16_t)(self->position + self->revolution * self->config.positions);
    if (self->mode != SYNCED) {
        tooth->edge_class = SD_EDGE_UNSYNCED;
        tooth->health = SD_INVALID;
        tooth->why |= SD_WHY_NO_SYNC;
    } else if (tooth->edge_class == SD_EDGE_SPURIOUS) {
        tooth->health = SD_INVALID;
    } else if ((self->doubtful | self->unsure) != 0u) {
        tooth->health = SD_DEGRADED;
        tooth->why |= SD_WHY_FAULT;
    } else {
        tooth->health = SD_VALID;
    }
}

void sd_crank_edge(sd_crank_t *self, uint32_t tick, sd_tooth_t *tooth) {
    *tooth = (sd_tooth_t){ .tick = tick, .edge_class = SD_EDGE_UNSYNCED };
    self->counts.edges++;
    const uint32_t period = tick - self->raw_tick;
    if (period > self->config.stall_ticks) { sd_crank_poll(self, tick); }
    const bool tracked = self->mode == SYNCED;
    self->raw_tick = tick;
    if (self->mode == WAITING) {
        self->mode = SEARCHING;
    } else {
        if (tracked && !sd_track_edge(self, tick, period, tooth)) { forget_angle(self, SEARCHING); }
        if (!tracked) { sd_search_edge(self, tick, period, tooth); }
        self->raw_period[0] = period;
    }
    describe(self, tooth);
}

void sd_crank_edges(sd_crank_t *self, const uint32_t *ticks, uint32_t count, sd_tooth_t *teeth) {
    for (uint32_t i = 0; i < count; ++i) { sd_crank_edge(self, ticks[i], &teeth[i]); }
}

bool sd_crank_phase_known(const sd_crank_t *self) { return self->phase_votes >= PHASE_VOTES; }

/* ---- phase, time, speed ---------------------------------------------------------------------------------------- */

void sd_crank_cam_edge(sd_crank_t *self, uint32_t tick) {
    const uint32_t n = self->config.positions;
    if ((self->mode != SYNCED) || (self->config.has_cam == 0u)) { self->counts.cam_rejected++; return; }
    const sd_crank_clock_t *lead = leading(self);
    const int32_t ahead = sd_clock_since(lead, tick) / ((lead->period + 1) / 2); /* half positions since the last placed edge */
    const uint32_t here = (uint32_t)(self->position + (ahead + 1) / 2) % n;
    const uint32_t off = (here + n - self->config.cam_position % n) % n;
    if ((off > n / 8u) && (off < n - n / 8u)) { self->counts.cam_rejected++; return; }
    /* An edge a little off may stand in the revolution before or after the one cam_position lies in. */
    const uint32_t crossed = (self->position > here) ? 1u : 0u;
    const uint32_t target = (self->config.cam_position + ((off <= n / 8u) ? off : 2u * n + off - n)) % (2u * n);
    const uint8_t revolution = (uint8_t)((target / n + crossed) & 1u);
    if (revolution == self->revolution) {
        if (self->phase_votes < PHASE_VOTES) { self->phase_votes++; }
    } else {
        self->counts.cam_rejected += (self->phase_votes > 0u) ? 1u : 0u;
        self->revolution = revolution;
        self->phase_votes = 1;
    }
}

bool sd_crank_poll(sd_crank_t *self, uint32_t tick) {
    if ((self->mode == WAITING) || (tick - self->raw_tick <= self->config.stall_ticks)) { return false; }
    forget_angle(self, WAITING);
    self->counts.stalls++;
    return true;
}

void sd_crank_lose_sync(sd_crank_t *self) { forget_angle(self, WAITING); }

sd_result_t sd_crank_set_stall(sd_crank_t *self, uint32_t stall_ticks) {
    if (!stall_in_range(stall_ticks)) { return SD_ERR_CONFIG; }
    self->config.stall_ticks = stall_ticks;
    return SD_OK;
}

sd_crank_motion_t sd_crank_motion_of(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz) {
    sd_crank_motion_t motion = { 0.0f, 0.0f };
    if (tooth->period_ticks == 0u) { return motion; }
    /* A division costs a controller as much as a dozen products. */
    motion.speed_radps = 6.2831853f * (float)tooth->span_spacings * tick_hz / ((float)self->turn_spacings * (float)tooth->period_ticks);
    const sd_crank_clock_t *lead = leading(self);
    if ((motion.speed_radps <= 0.0f) || (lead->period <= 0)) { return motion; }
    const float period = (float)lead->period; /* 1/64 tick */
    motion.acceleration_radps2 = -motion.speed_radps * (float)lead->change * (64.0f * tick_hz) / (period * period);
    return motion;
}
