/* SPDX-License-Identifier: MIT */
#include "sd_driveline_hybrid.h"

#include "sd_math.h"

#define LEAVE_FACTOR 0.5f /* a neighbour's residual must be below so much of the present one's */
#define INPUT_MOST   1e6f

_Static_assert(sizeof(sd_driveline_hybrid_t) == 72, "without pointers, the same size on every target");

sd_result_t sd_driveline_hybrid_init(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, uint8_t location) {
    const bool ok = sd_above_to(bank->period_s, 0.0f, 1.0f) && sd_above_to(bank->threshold_rpm, 0.0f, 1e4f) &&
                    sd_within(bank->rpm_per_radps, 1.0f, 100.0f) && sd_within(bank->middle_rad, -10.0f, 10.0f) &&
                    sd_within(bank->settle_s, 0.0f, 100.0f) && sd_within(bank->ratio, 0.0f, 2.0f) &&
                    sd_within(bank->hold_s, 0.0f, 10.0f) && sd_within(bank->calm_s, 0.0f, 10.0f) && (location >= 1u) &&
                        (location <= (uint8_t)SD_DRIVELINE_LOCATIONS);
    if (!ok) { return SD_ERR_CONFIG; }
    *self = (sd_driveline_hybrid_t){ .location = location, .may_leave = 1 };
    return SD_OK;
}

typedef struct inputs {
    float torque_nm, road_nm, speed_rpm[2];
} inputs_t;

static void step_map(const sd_driveline_map_t *map, const inputs_t *in, float x[3]) {
    float next[3];
    for (uint32_t i = 0; i < 3u; ++i) {
        next[i] = map->constant[i] + map->by_torque[i] * in->torque_nm + map->by_road[i] * in->road_nm +
                  map->by_speed[0][i] * in->speed_rpm[0] + map->by_speed[1][i] * in->speed_rpm[1];
        for (uint32_t j = 0; j < 3u; ++j) { next[i] += map->by_state[i][j] * x[j]; }
    }
    for (uint32_t i = 0; i < 3u; ++i) { x[i] = next[i]; }
}

/* Which location the residuals speak of. */
static uint8_t identify(uint8_t q, const float *residual, float threshold, bool forward) {
    const float own = __builtin_fabsf(residual[q - 1u]);
    if (own <= threshold) { return q; }
    const uint8_t neighbour = (q != 2u) ? 2u : (forward ? 3u : 1u);
    return (__builtin_fabsf(residual[neighbour - 1u]) < LEAVE_FACTOR * own) ? neighbour : q;
}

static void say(const sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, bool taken, sd_driveline_hybrid_out_t *out) {
    for (uint32_t i = 0; i < 3u; ++i) { out->x[i] = self->x[i]; }
    bool any = false;
    for (uint32_t j = 0; j < (uint32_t)SD_DRIVELINE_LOCATIONS; ++j) {
        out->residual_rpm[j] = bank->rpm_per_radps * self->z[j][1] - self->last_speed_rpm;
        out->fits[j] = (__builtin_fabsf(out->residual_rpm[j]) <= bank->threshold_rpm) ? 1u : 0u;
        any = any || (out->fits[j] != 0u);
    }
    out->location = self->location;
    const float own = out->residual_rpm[self->location - 1u];
    out->status = (sd_status_t){ .rejected = self->rejected, .innovation = own, .test_ratio = __builtin_fabsf(own) / bank->threshold_rpm };
    if (self->run_s < bank->settle_s) { sd_status_worst_of(&out->status, SD_INVALID, SD_WHY_CONVERGING); }
    if (!any || !taken) { sd_status_worst_of(&out->status, SD_DEGRADED, SD_WHY_REJECTED); }
}

static void begin(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, float speed_rpm) {
    self->begun = 1;
    self->last_speed_rpm = speed_rpm;
    if (bank->ratio <= 0.0f) { return; }
    const float speed_radps = speed_rpm / bank->rpm_per_radps;
    for (uint32_t j = 0; j < (uint32_t)SD_DRIVELINE_LOCATIONS; ++j) {
        self->z[j][1] = speed_radps;
        self->z[j][2] = bank->ratio * speed_radps;
    }
    self->x[1] = speed_radps;
    self->x[2] = bank->ratio * speed_radps;
}

/* By how its residual has behaved, a location is kept or left for a neighbour. */
static void choose(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, sd_driveline_hybrid_out_t *out) {
    self->since_s += bank->period_s;
    self->calm_s = (out->fits[self->location - 1u] != 0u) ? self->calm_s + bank->period_s : 0.0f;
    if ((self->since_s >= bank->hold_s) || (self->calm_s >= bank->calm_s)) { self->may_leave = 1; }
    if (self->may_leave == 0u) { return; }
    const uint8_t next = identify(self->location, out->residual_rpm, bank->threshold_rpm, self->x[0] >= bank->middle_rad);
    if (next == self->location) { return; }
    self->since_s = self->calm_s = 0.0f;
    self->may_leave = 0;
    self->location = out->location = next;
    out->changed = 1;
}

void sd_driveline_hybrid_step(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, float torque_nm, float road_nm, float speed_rpm,
                              sd_driveline_hybrid_out_t *out) {
    *out = (sd_driveline_hybrid_out_t){ .location = 0 };
    if (!sd_within(torque_nm, -INPUT_MOST, INPUT_MOST) || !sd_within(road_nm, -INPUT_MOST, INPUT_MOST) ||
        !sd_within(speed_rpm, -INPUT_MOST, INPUT_MOST)) {
        self->rejected = (uint16_t)(self->rejected + ((self->rejected < UINT16_MAX) ? 1u : 0u));
        say(self, bank, false, out);
        return;
    }
    if (self->begun == 0u) { begin(self, bank, speed_rpm); }
    const inputs_t in = { torque_nm, road_nm, { self->last_speed_rpm, speed_rpm } };
    for (uint32_t j = 0; j < (uint32_t)SD_DRIVELINE_LOCATIONS; ++j) { step_map(&bank->residual[j], &in, self->z[j]); }
    step_map(&bank->observer[self->location - 1u], &in, self->x);
    self->last_speed_rpm = speed_rpm;
    if (self->run_s < bank->settle_s) { self->run_s += bank->period_s; }
    say(self, bank, true, out);
    choose(self, bank, out);
}
