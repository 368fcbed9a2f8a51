/* SPDX-License-Identifier: MIT */
#include "sd_course.h"

#include "sd_value.h"

#define TWO_PI 6.2831853f

static void begin_cycle(sd_course_t *self) {
    self->cycle_ticks = 0;
    self->cycle_positions = 0;
    self->spoilt = 0;
}

sd_course_jump_t sd_course_follow(sd_course_t *self, const sd_tooth_t *tooth, uint32_t positions) {
    const uint32_t cycle = 2u * positions, from = (uint32_t)self->position + tooth->advance;
    const uint32_t expected = (from >= cycle) ? from - cycle : from;
    sd_course_jump_t jump = SD_COURSE_RESTART;
    if (self->following != 0u) {
        const bool shifted = (tooth->cycle_position == expected + positions) || (tooth->cycle_position + positions == expected);
        jump = (tooth->cycle_position == expected) ? SD_COURSE_NONE : shifted ? SD_COURSE_SHIFTED : SD_COURSE_RESTART;
    }
    if (jump != SD_COURSE_NONE) { begin_cycle(self); }
    self->following = 1;
    return jump;
}

bool sd_course_ended(sd_course_t *self, const sd_tooth_t *tooth, uint32_t positions, float tick_hz, sd_cycle_t *cycle) {
    if (tooth->cycle_position >= self->position) { return false; }
    const sd_value_t turns = V(div)(V(int)((int32_t)self->cycle_positions), V(int)((int32_t)positions));
    const sd_value_t radians_hz = V(mul)(V(mul)(V(of)(TWO_PI), turns), V(of)(tick_hz));
    const bool turned = self->cycle_ticks > 0u;
    *cycle = (sd_cycle_t){ .tick = tooth->tick,
                           .speed_radps = turned ? V(float)(V(div)(radians_hz, V(int)((int32_t)self->cycle_ticks))) : 0.0f,
                           .whole = self->cycle_positions >= 2u * positions,
                           .clean = self->spoilt == 0u,
                           .phase_known = tooth->phase_known != 0u };
    begin_cycle(self);
    return true;
}

void sd_course_add(sd_course_t *self, const sd_tooth_t *tooth, bool good) {
    self->cycle_ticks += tooth->period_ticks;
    self->cycle_positions += tooth->advance;
    self->position = tooth->cycle_position;
    if (!good) { self->spoilt = 1; }
}

void sd_course_lose(sd_course_t *self) { self->following = 0; }
