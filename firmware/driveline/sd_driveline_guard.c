/* SPDX-License-Identifier: MIT */
#include "sd_driveline_guard.h"

#include "sd_math.h"

#define TORQUE_MOST_NM 20000.0f
#define MEAN_TEETH     16.0f
#define GRACE          1.5f /* settling times until the mean lateness counts: the start's gains leave an error of speed behind */
#define STRIKES_MOST   8u /* teeth left out in a row: the filter begins anew */

_Static_assert(sizeof(sd_driveline_guard_t) == 76, "without pointers, the same size on every target");

static bool in_range(const sd_driveline_tables_t *t) {
    bool ok = sd_above_to(t->tick_s, 0.0f, 1e-3f) && sd_above_to(t->pitch_rad, 0.0f, 0.6f) && sd_within(t->wheel_pitch_rad, 0.0f, 3.2f) &&
              sd_above_to(t->shortest_s, 0.0f, 1.0f) && sd_above_to(t->per_inertia, 0.0f, 1e4f) &&
                  sd_within(t->viscous_nms, 0.0f, 100.0f) &&
              sd_above_to(t->per_vehicle, 0.0f, 1e4f) && sd_within(t->soft_nmprad, 0.0f, 1e7f) && sd_within(t->stiff_nmprad, 1.0f, 1e7f) &&
              sd_within(t->damping_nms, 0.0f, 1e6f) && sd_above_to(t->kink_rad, 0.0f, 1.0f) && sd_within(t->rolling_nm, 0.0f, 1e5f) &&
              sd_within(t->drag_nms2, 0.0f, 1e4f) && sd_above_to(t->reject_rad, 0.0f, 1.0f) && sd_within(t->per_reject, 1.0f, 1e9f) &&
              sd_above_to(t->doubt_rad, 0.0f, 1.0f) &&
                  sd_within(t->settle_s, 0.0f, 100.0f) &&
              sd_within(t->moving_radps, 0.0f, 1e6f) && sd_within(t->moving_hold_s, 0.0f, 100.0f) &&
              (t->gears <= SD_DRIVELINE_GEARS_MAX) && (t->guard <= (uint8_t)SD_GUARD_TORQUE);
    for (uint32_t g = 0; ok && (g < t->gears); ++g) { ok = sd_above_to(t->gear[g].ratio, 0.0f, 2.0f); }
    return ok;
}

sd_result_t sd_driveline_guard_init(sd_driveline_guard_t *self, const sd_driveline_tables_t *tables) {
    if ((tables->gears != 0u) && !in_range(tables)) { return SD_ERR_CONFIG; }
    *self = (sd_driveline_guard_t){ .location = 0 };
    return SD_OK;
}

void sd_driveline_guard_restart(sd_driveline_guard_t *self) { self->gear = 0; }

static uint8_t location_of(float value, float limit) {
    if (__builtin_fabsf(value) <= limit) { return 2u; }
    return (value > 0.0f) ? 3u : 1u;
}

/* The spring's torque: stiffness times torsion, plus what the law of the torsion's own location adds. */
typedef struct law {
    float stiffness_nmprad, constant_nm;
} law_t;

static inline law_t law_of(const sd_driveline_tables_t *t, uint8_t location) {
    if (location == 2u) { return (law_t){ t->soft_nmprad, 0.0f }; }
    const float preload = (t->stiff_nmprad - t->soft_nmprad) * t->kink_rad;
    return (law_t){ t->stiff_nmprad, (location == 3u) ? -preload : preload };
}

static float road_nm(const sd_driveline_tables_t *t, float wheel_radps) {
    return t->rolling_nm * sd_clamp(2.0f * wheel_radps, -1.0f, 1.0f) + t->drag_nms2 * wheel_radps * __builtin_fabsf(wheel_radps);
}

/* The midpoint rule over h seconds. The law and the road are those of its start: a step in which the shaft passes the kink is rare and
 * errs by less than a tooth's jitter does. */
static void propagate(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, float ratio, float h) {
    float *x = self->x;
    const float torque = self->torque_nm + x[SD_DRIVELINE_BIAS], road = road_nm(t, x[SD_DRIVELINE_WHEEL]);
    const law_t law = law_of(t, self->by_angle);
    const float speed = x[SD_DRIVELINE_SPEED], wheel = x[SD_DRIVELINE_WHEEL], twist = x[SD_DRIVELINE_TWIST];
    /* read before anything is written, so that each is read once */
    const float half = 0.5f * h, damping = t->damping_nms, viscous = t->viscous_nms, pitch = t->pitch_rad;
    const float half_engine = half * t->per_inertia, half_vehicle = half * t->per_vehicle;
    const float winding = ratio * speed - wheel;
    const float shaft = law.stiffness_nmprad * twist + law.constant_nm + damping * winding;
    const float half_speed = speed + half_engine * (torque - viscous * speed - ratio * shaft);
    const float half_wheel = wheel + half_vehicle * (shaft - road);
    const float half_winding = ratio * half_speed - half_wheel;
    const float half_shaft = law.stiffness_nmprad * (twist + half * winding) + law.constant_nm + damping * half_winding;
    x[SD_DRIVELINE_PHASE] += h * half_speed - pitch;
    x[SD_DRIVELINE_SPEED] = speed + 2.0f * half_engine * (torque - viscous * half_speed - ratio * half_shaft);
    x[SD_DRIVELINE_TWIST] = twist + h * half_winding;
    x[SD_DRIVELINE_WHEEL] = wheel + 2.0f * half_vehicle * (half_shaft - road);
    x[SD_DRIVELINE_WHEEL_PHASE] += h * half_wheel;
}

/* The gains of a step of h seconds. An octave is found in the exponent of h. */
static void blend(const sd_driveline_gain_t *octaves, float h_over_shortest, sd_driveline_gain_t *gain) {
    union { float f; uint32_t u; } step = { sd_clamp(h_over_shortest, 1.0f, 255.99f) };
    const uint32_t octave = (step.u >> 23) - 127u;
    step.u = (step.u & 0x7fffffu) | 0x3f800000u;
    const float share = step.f - 1.0f;
    const float *low = octaves[octave].of, *high = octaves[octave + 1u].of;
    for (uint32_t i = 0; i < (uint32_t)SD_DRIVELINE_STATES; ++i) { gain->of[i] = low[i] + share * (high[i] - low[i]); }
}

static void correct(sd_driveline_guard_t *self, const sd_driveline_gain_t *gain, float late) {
    _Pragma("GCC unroll 6")
    for (uint32_t i = 0; i < (uint32_t)SD_DRIVELINE_STATES; ++i) { self->x[i] += gain->of[i] * late; }
}

/* Gains are kept from tooth to tooth while the step lasts the same within 3 % and the same table holds. */
static void correct_by_tooth(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, const sd_driveline_gear_t *gear, float step,
                             float late) {
    const uint8_t table = (uint8_t)(((self->location == 2u) ? 0u : 1u) + ((self->settled_s < t->settle_s) ? 2u : 0u));
    if ((table != self->table) || !(__builtin_fabsf(step - self->gain_s) <= 0.03f * self->gain_s)) {
        const sd_driveline_gain_t *octaves = (table >= 2u) ? gear->start[table - 2u] : gear->tooth[table];
        blend(octaves, step / t->shortest_s, &self->gain);
        self->gain_s = step;
        self->table = table;
    }
    correct(self, &self->gain, late);
}

/* The torsion that a torque at the crank holds, and a shaft at rest. */
static void begin(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, const sd_driveline_tooth_t *tooth, float h) {
    const float ratio = t->gear[tooth->gear - 1u].ratio;
    const float speed = (float)tooth->advance * t->pitch_rad / h;
    const float spring = (self->torque_nm + self->x[SD_DRIVELINE_BIAS] - t->viscous_nms * speed) / ratio;
    const float at_kink = t->soft_nmprad * t->kink_rad;
    const uint8_t location = location_of(spring, at_kink);
    float twist = (location == 2u) ? spring / ((t->soft_nmprad > 1.0f) ? t->soft_nmprad : 1.0f) : t->kink_rad;
    if (location == 3u) { twist = t->kink_rad + (spring - at_kink) / t->stiff_nmprad; }
    if (location == 1u) { twist = -t->kink_rad + (spring + at_kink) / t->stiff_nmprad; }
    self->x[SD_DRIVELINE_PHASE] = 0.0f;
    self->x[SD_DRIVELINE_SPEED] = speed;
    self->x[SD_DRIVELINE_TWIST] = twist;
    self->x[SD_DRIVELINE_WHEEL] = ratio * speed;
    self->x[SD_DRIVELINE_WHEEL_PHASE] = 0.0f;
    self->gear = tooth->gear;
    self->location = self->by_angle = location;
    self->settled_s = self->still_s = 0.0f;
    self->strikes = 0;
    self->gain_s = self->mean_late_rad = 0.0f;
}

static void judge(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, const sd_driveline_tooth_t *tooth, bool taken,
                  sd_driveline_out_t *out) {
    if (self->settled_s < t->settle_s) { sd_status_worst_of(&out->status, SD_INVALID, SD_WHY_CONVERGING); }
    if (tooth->health != (uint8_t)SD_VALID) {
        sd_status_worst_of(&out->status, SD_DEGRADED, SD_WHY_FAULT);
    } else if (!taken) {
        self->rejected = (uint16_t)(self->rejected + ((self->rejected < UINT16_MAX) ? 1u : 0u));
        sd_status_worst_of(&out->status, SD_DEGRADED, SD_WHY_REJECTED);
    }
    out->status.rejected = self->rejected;
}

/* Where the shaft stands, and what is said of it. The filter's crank is lead_rad ahead of the real one, and so is its end of the shaft. */
static void say(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, float ratio, float step, float lead, float late,
                sd_driveline_out_t *out) {
    const float twist = self->x[SD_DRIVELINE_TWIST] - ratio * lead;
    const float winding = ratio * self->x[SD_DRIVELINE_SPEED] - self->x[SD_DRIVELINE_WHEEL];
    const uint8_t by_angle = location_of(twist, t->kink_rad);
    const law_t law = law_of(t, by_angle);
    const float spring = law.stiffness_nmprad * twist + law.constant_nm;
    /* By torque: what the model lacks is laid to the shaft, not to the engine. */
    const uint8_t location = (t->guard == (uint8_t)SD_GUARD_ANGLE)
                                 ? by_angle
                                 : location_of(spring - self->x[SD_DRIVELINE_BIAS] / ratio, t->soft_nmprad * t->kink_rad);
    out->changed = (location != self->location) ? 1u : 0u;
    self->by_angle = by_angle;
    self->location = out->location = location;
    self->still_s = (__builtin_fabsf(winding) > t->moving_radps) ? 0.0f : self->still_s + step;
    out->moving = (self->still_s < t->moving_hold_s) ? 1u : 0u;
    out->twist_rad = twist;
    out->shaft_nm = ratio * (spring + t->damping_nms * winding);
    out->winding_radps = winding;
    out->wheel_radps = self->x[SD_DRIVELINE_WHEEL];
    out->bias_nm = self->x[SD_DRIVELINE_BIAS];
    out->status.health = (uint8_t)SD_VALID;
    out->status.why = 0;
    out->status.innovation = late;
    out->status.test_ratio = __builtin_fabsf(late) * t->per_reject;
}

static void rest(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, sd_driveline_out_t *out) {
    self->gear = 0;
    *out = (sd_driveline_out_t){ .location = 0 };
    out->status = (sd_status_t){ .health = SD_INVALID, .rejected = self->rejected,
                                 .why = (t->gears == 0u) ? (uint16_t)SD_WHY_UNCALIBRATED : (uint16_t)SD_WHY_NO_INPUT };
}

void sd_driveline_guard_step(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, const sd_driveline_tooth_t *tooth,
                             sd_driveline_out_t *out) {
    if (__builtin_fabsf(tooth->torque_nm) <= TORQUE_MOST_NM) { self->torque_nm = tooth->torque_nm; }
    const bool usable = (tooth->gear >= 1u) && (tooth->gear <= t->gears) && (tooth->period_ticks != 0u) && (tooth->advance >= 1u) &&
                        (tooth->advance <= 120u);
    if (!usable) {
        rest(self, t, out);
        return;
    }
    const float step = (float)tooth->period_ticks * t->tick_s;
    const sd_driveline_gear_t *gear = &t->gear[tooth->gear - 1u];
    bool taken = true;
    float late = 0.0f;
    if (tooth->gear != self->gear) {
        begin(self, t, tooth, step);
    } else {
        const float h = (tooth->advance == 1u) ? step : step / (float)tooth->advance;
        for (uint32_t k = 0; k < tooth->advance; ++k) { propagate(self, t, gear->ratio, h); }
        late = tooth->place_rad + tooth->lead_rad - self->x[SD_DRIVELINE_PHASE];
        const bool near = __builtin_fabsf(late) <= t->reject_rad;
        taken = near && (tooth->health == (uint8_t)SD_VALID);
        if (taken) {
            correct_by_tooth(self, t, gear, step, late);
            self->mean_late_rad += (late - self->mean_late_rad) * (1.0f / MEAN_TEETH);
        }
        if (self->settled_s < GRACE * t->settle_s) {
            self->settled_s += step;
        } else if (__builtin_fabsf(self->mean_late_rad) > t->doubt_rad) {
            self->mean_late_rad = 0.0f; /* it is not where it believes to be */
            self->settled_s = step;
        }
        self->strikes = (uint8_t)(near ? 0u : self->strikes + 1u);
    }
    say(self, t, gear->ratio, step, tooth->lead_rad, late, out);
    judge(self, t, tooth, taken, out);
    if (self->strikes >= STRIKES_MOST) { self->gear = 0; }
}

void sd_driveline_guard_wheel(sd_driveline_guard_t *self, const sd_driveline_tables_t *t, uint32_t since_ticks, uint16_t advance) {
    if ((self->gear == 0u) || (t->wheel_pitch_rad <= 0.0f) || (advance == 0u)) { return; }
    const sd_driveline_gear_t *gear = &t->gear[self->gear - 1u];
    float *x = self->x;
    const float since = (float)since_ticks * t->tick_s;
    x[SD_DRIVELINE_WHEEL_PHASE] -= (float)advance * t->wheel_pitch_rad;
    const float late = -(x[SD_DRIVELINE_WHEEL_PHASE] + since * x[SD_DRIVELINE_WHEEL]);
    if (!sd_within(late, -0.5f * t->wheel_pitch_rad, 0.5f * t->wheel_pitch_rad)) {
        x[SD_DRIVELINE_WHEEL_PHASE] = -since * x[SD_DRIVELINE_WHEEL];
        return;
    }
    const uint32_t stiff = (self->location == 2u) ? 0u : 1u;
    sd_driveline_gain_t gain;
    blend(gear->wheel[stiff], t->pitch_rad / (sd_clamp(x[SD_DRIVELINE_SPEED], 1.0f, 1e4f) * t->shortest_s), &gain);
    correct(self, &gain, late);
}
