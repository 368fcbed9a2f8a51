/* SPDX-License-Identifier: MIT */
#include "sd_driveline_guard.h"

#define N f32
#define T float
#define SPEED_MOST 1e4f
#define MODEL      sd_driveline_tables_t
#include "sd_parts.inc"

_Static_assert(sizeof(sd_driveline_guard_f32_t) == 76, "without pointers, the same size on every target");

/* The tables are the model, and a gear is entered by reading them. */
static inline bool fits(const sd_driveline_guard_f32_t *self, const sd_driveline_tables_t *t) {
    (void)self;
    (void)t;
    return true;
}
static inline void enter(const sd_driveline_guard_f32_t *self, const sd_driveline_tables_t *t, uint32_t gear) {
    (void)self;
    (void)t;
    (void)gear;
}
static inline const MODEL *model_of(const sd_driveline_guard_f32_t *self, const sd_driveline_tables_t *t) {
    (void)self;
    return t;
}
static inline float ratio_of(const sd_driveline_guard_f32_t *self, const sd_driveline_tables_t *t, uint32_t gear) {
    (void)self;
    return t->gear[gear].ratio;
}

static inline float seconds_of(const MODEL *m, uint32_t ticks) { return (float)ticks * m->tick_s; }
static inline float part_of(float step, uint16_t parts) { return step / (float)parts; }
static inline float lasting(float step) { return step; }
static inline float turned(uint16_t advance, float pitch, int down) {
    (void)down;
    return (float)advance * pitch;
}

/* Of the rolling resistance: all of it from half a radian a second on. */
static inline float sense(float wheel) { return sd_clamp(2.0f * wheel, -1.0f, 1.0f); }

/* An octave is found in the exponent. */
static inline uint32_t octave_of(float step_over_shortest, float *share) {
    union { float f; uint32_t u; } step = { sd_clamp(step_over_shortest, 1.0f, 255.99f) };
    const uint32_t octave = (step.u >> 23) - 127u;
    step.u = (step.u & 0x7fffffu) | 0x3f800000u;
    *share = step.f - 1.0f;
    return octave;
}

static inline sd_gain_f32_t between(float low, float share, float high, int bits) {
    (void)bits;
    return (sd_gain_f32_t){ low + share * (high - low) };
}

#include "sd_driveline_guard.inc"
