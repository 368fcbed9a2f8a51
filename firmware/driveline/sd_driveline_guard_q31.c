/* SPDX-License-Identifier: MIT */
#include "sd_driveline_guard.h"

#define N q31
#define T sd_q31_t
#define SPEED_MOST INT32_MAX
#define MODEL      sd_driveline_model_q31_t
#include "sd_parts.inc"

_Static_assert(sizeof(sd_driveline_guard_q31_t) == 184, "without pointers, the same size on every target");

/* A number of the model, and whether it has room in its base. */
static bool given(float x, int bits, sd_q31_t *to) {
    *to = sd_given_q31(x, bits);
    return *to < INT32_MAX;
}

/* What only limits something may stand at the end of its base. */
static void take_limits(MODEL *m, const sd_driveline_tables_t *t) {
    m->reject_rad = sd_given_q31(t->reject_rad, SD_DRIVELINE_PHASE_BITS);
    m->per_reject = sd_given_q31(t->per_reject, SD_DRIVELINE_PER_REJECT_BITS);
    m->doubt_rad = sd_given_q31(t->doubt_rad, SD_DRIVELINE_PHASE_BITS);
    m->settle_s = sd_given_q31(t->settle_s, SD_DRIVELINE_TIME_BITS);
    m->moving_radps = sd_given_q31(t->moving_radps, SD_DRIVELINE_WHEEL_BITS);
    m->moving_hold_s = sd_given_q31(t->moving_hold_s, SD_DRIVELINE_TIME_BITS);
}

static bool take_model(MODEL *m, const sd_driveline_tables_t *t) {
    const sd_scaled_t tick = sd_scaled_of(t->tick_s);
    const int32_t down = SD_DRIVELINE_STEP_BITS - tick.exponent;
    m->tick = (uint32_t)tick.mantissa;
    m->tick_down = (uint32_t)((down < 63) ? down : 63);
    take_limits(m, t);
    return given(t->pitch_rad, SD_DRIVELINE_PHASE_BITS, &m->pitch_rad) && given(t->shortest_s, SD_DRIVELINE_STEP_BITS, &m->shortest_s) &&
           given(t->wheel_pitch_rad, SD_DRIVELINE_WHEEL_PHASE_BITS, &m->wheel_pitch_rad) &&
           given(t->per_inertia, SD_DRIVELINE_PER_INERTIA_BITS, &m->per_inertia) &&
           given(t->per_vehicle, SD_DRIVELINE_PER_VEHICLE_BITS, &m->per_vehicle) &&
           given(t->viscous_nms, SD_DRIVELINE_VISCOUS_BITS, &m->viscous_nms) && given(t->kink_rad, SD_DRIVELINE_TWIST_BITS, &m->kink_rad) &&
           given(t->soft_nmprad, SD_DRIVELINE_STIFFNESS_BITS, &m->soft_nmprad) &&
           given(t->stiff_nmprad, SD_DRIVELINE_STIFFNESS_BITS, &m->stiff_nmprad) &&
           given(t->damping_nms, SD_DRIVELINE_DAMPING_BITS, &m->damping_nms) &&
           given(t->rolling_nm, SD_DRIVELINE_SHAFT_BITS, &m->rolling_nm) && given(t->drag_nms2, SD_DRIVELINE_DRAG_BITS, &m->drag_nms2);
}

static bool fits_one_sum(sd_q31_t a, sd_q31_t b) {
    const sd_q31_t both[] = { a, b };
    return sd_wide_fits_q31(both, 2);
}

/* Makes the model; whether all of it has room, with the ratio of each gear. */
static bool fits(sd_driveline_guard_q31_t *self, const sd_driveline_tables_t *t) {
    MODEL *m = &self->model;
    bool ok = take_model(m, t) && fits_one_sum(m->soft_nmprad, m->damping_nms) && fits_one_sum(m->stiff_nmprad, m->damping_nms);
    for (uint32_t g = 0; ok && (g < t->gears); ++g) {
        ok = given(t->gear[g].ratio, SD_DRIVELINE_RATIO_BITS, &m->ratio) && fits_one_sum(m->viscous_nms, m->ratio);
    }
    return ok;
}
static void enter(sd_driveline_guard_q31_t *self, const sd_driveline_tables_t *t, uint32_t gear) {
    self->model.ratio = sd_given_q31(t->gear[gear].ratio, SD_DRIVELINE_RATIO_BITS);
}
static inline const MODEL *model_of(const sd_driveline_guard_q31_t *self, const sd_driveline_tables_t *t) {
    (void)t;
    return &self->model;
}
static inline sd_q31_t ratio_of(const sd_driveline_guard_q31_t *self, const sd_driveline_tables_t *t, uint32_t gear) {
    (void)t;
    (void)gear;
    return self->model.ratio;
}

static sd_q31_t seconds_of(const MODEL *m, uint32_t ticks) {
    const uint64_t step = ((uint64_t)ticks * m->tick) >> m->tick_down;
    return (step < (uint64_t)INT32_MAX) ? (sd_q31_t)step : INT32_MAX;
}
static inline sd_q31_t part_of(sd_q31_t step, uint16_t parts) { return step / (sd_q31_t)parts; }
static inline sd_q31_t lasting(sd_q31_t step) { return step >> (SD_DRIVELINE_TIME_BITS - SD_DRIVELINE_STEP_BITS); }
static inline sd_q31_t turned(uint16_t advance, sd_q31_t pitch, int down) { return sd_sat_q31(((int64_t)advance * pitch) >> down); }

/* Of the rolling resistance: all of it from half a radian a second on. */
static inline sd_q31_t sense(sd_q31_t wheel) {
    const sd_q31_t most = (1 << (30 - SD_DRIVELINE_WHEEL_BITS)) - 1;
    return sd_within_q31(wheel, most) * (1 << (SD_DRIVELINE_WHEEL_BITS + 1));
}

/* An octave is found in the number of leading zeros; the quotient is per unit of 2^8. */
static inline uint32_t octave_of(sd_q31_t step_over_shortest, sd_q31_t *share) {
    const uint32_t quotient = (step_over_shortest > (1 << 23)) ? (uint32_t)step_over_shortest : 1u << 23;
    const uint32_t zeros = (uint32_t)__builtin_clz(quotient);
    *share = (sd_q31_t)((quotient << zeros) & 0x7fffffffu);
    return 8u - zeros;
}

/* Both on the scale of the larger one, with a bit of room for their difference. */
static sd_gain_q31_t between(float low, sd_q31_t share, float high, int bits) {
    const sd_scaled_t a = sd_scaled_of(low), b = sd_scaled_of(high);
    const int32_t exponent = (((b.mantissa == 0) || ((a.mantissa != 0) && (a.exponent > b.exponent))) ? a.exponent : b.exponent) + 1;
    const int32_t from = sd_scaled_fit(a.mantissa, a.exponent - exponent), to = sd_scaled_fit(b.mantissa, b.exponent - exponent);
    return sd_gain_scaled_q31((sd_scaled_t){ sd_add_q31(from, sd_part_q31(share, sd_sub_q31(to, from))), exponent + bits });
}

#include "sd_driveline_guard.inc"
