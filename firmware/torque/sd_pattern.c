/* SPDX-License-Identifier: MIT */
#include "sd_pattern.h"

#include <string.h>

#define W_REF_RADPS SD_PATTERN_REFERENCE_RADPS
#define SLOPE_MAX   1e-3f  /* rad per rad: the guess is good enough for the trend to be linear in it */
#define MODES_SETTLED 8u   /* cycles after which it is forgotten how the modes swung at the start */
#define SPREAD_MIN  0.05f  /* of u, relative: below it one speed only was seen */
#define MOTORED_SD  0.03f  /* of the motored torque, relative, while the speeds do not tell */
#define EXPONENT_SD 0.06f  /* of compression's exponent, before it is learned */
#define UNSEEN_RAD  1.75e-5f /* 0.001 deg: what a motored torque with the right exponent still errs by, the same in every cycle */
#define PATTERN_RAD 3.5e-4f  /* 0.02 deg: no wheel's pattern is taken for smaller */
#define RESUME_ROUNDS 4u   /* pattern and exponent from each other, as in the cycles that they were learned in */
#define LATE_MAX    10.0f  /* rad: beyond it, it is no crank that turns */
#define PIECE       2u     /* positions of the last cycle that go into the sums at a tooth */

#if SD_CYLINDERS_MAX == 8
_Static_assert(sizeof(sd_pattern_t) == 4684, "without pointers, the same size on every target");
#endif

/* ---- the last cycle goes into the sums ------------------------------------------------------------------------- */

/* How the sums tell pattern from motored torque. */
typedef struct sd_fit {
    float cycles, u, uu;
    float spread; /* of u, relative */
    float common, common_u; /* c sum r, c sum u r: over S_k what the exponent makes of a tooth's sums */
    bool  pooled;
} sd_fit_t;

static sd_fit_t fit_of(const sd_pattern_sums_t *s, const sd_pattern_work_t *w, bool with_work) {
    const float one = with_work ? 1.0f : 0.0f, cycles = s->cycles + one, u = s->u + one * w->u, uu = s->uu + one * w->u * w->u;
    const float spread = 1.0f - u * u / (cycles * uu);
    return (sd_fit_t){ cycles, u, uu, spread, w->exponent * (s->r + one * w->r), w->exponent * (s->ur + one * w->u * w->r),
                       spread > SPREAD_MIN };
}

static float common_late(const sd_kalman_tables_t *t, uint32_t k) { return sd_motion_word(t, k)[SD_ROW_LATE].value; }

/* Lateness of tooth k in the last cycle: mean of both revolutions, trend and mean of all teeth taken out. */
static float late_of(const sd_pattern_t *self, const sd_kalman_tables_t *t, uint32_t k) {
    const float at = (float)k, next = (float)(k + t->positions);
    const float trend = self->work.a1 * (at + next) + self->work.a2 * (at * at + next * next);
    return 0.5f * (self->cycle_rad[k] + self->cycle_rad[k + t->positions] - trend) - self->work.mean_rad;
}

/* The tooth's constant, and where the speeds tell, its slope over u; adds what they explain of its sums. */
static void place_tooth(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_fit_t *fit, uint32_t k) {
    const float common = common_late(t, k);
    const float late = self->sums.late[k] - common * fit->common, late_u = self->sums.late_u[k] - common * fit->common_u;
    float constant = late / fit->cycles, slope = 0.0f;
    if (fit->pooled) {
        constant = (constant - fit->u / (fit->cycles * fit->uu) * late_u) / fit->spread;
        slope = (late_u - fit->u * constant) / fit->uu;
    }
    self->late_rad[k] = constant;
    self->work.pattern_square += constant * constant;
    self->work.explained += constant * late + slope * late_u;
    self->work.late_common_sums += common * self->sums.late[k];
    self->work.common_square += common * common;
}

/* Compression's exponent from the sums, for the cycles to come; v: variance that the fit leaves of a tooth in a cycle. */
static void find_exponent(sd_pattern_t *self, const sd_kalman_tables_t *t, float v) {
    const sd_pattern_sums_t *s = &self->sums;
    const sd_pattern_work_t *w = &self->work;
    const float pattern = w->pattern_square / (float)t->teeth, least = PATTERN_RAD * PATTERN_RAD;
    const float unseen = v + s->cycles * UNSEEN_RAD * UNSEEN_RAD;
    const float together = s->cycles + unseen / ((pattern > least) ? pattern : least);
    const float information = w->common_square * (s->rr - s->r * s->r / together) + unseen / (EXPONENT_SD * EXPONENT_SD);
    const float c = (s->late_common - s->r * w->late_common_sums / together) / information;
    self->exponent_next = sd_clamp(c, -SD_PATTERN_EXPONENT_MAX, SD_PATTERN_EXPONENT_MAX);
    self->exponent_sd = sd_root(unseen / information);
}

/* Standard deviation from what the fit leaves; and the exponent for the next time. */
static void conclude(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_fit_t *fit) {
    const sd_pattern_work_t *w = &self->work;
    const sd_pattern_sums_t *s = &self->sums;
    const float c = w->exponent, common = c * (2.0f * s->late_common - c * w->common_square * s->rr);
    self->pooled = fit->pooled ? 1u : 0u;
    self->exponent = c;
    float left = s->square - (w->explained + common) / (float)t->teeth;
    left = ((left > 0.0f) ? left / (fit->cycles - 2.0f) : 0.0f) + 1e-12f; /* 6e-5 deg: no wheel is known better */
    find_exponent(self, t, left);
    const float twist = fit->pooled ? 0.0f : MOTORED_SD * self->ripple_nm / (4.0f * w->scale_nm);
    const float exponent = fit->pooled ? 0.0f : self->exponent_sd * s->r / s->cycles; /* what it leaves is taken for pattern */
    const float effective = fit->pooled ? fit->cycles * fit->spread : fit->cycles;
    self->sd_rad = sd_root(left / effective + twist * twist + exponent * exponent * w->common_square / (float)t->teeth);
}

/* The cycle is in the sums of all teeth. */
static void count_cycle(const sd_pattern_work_t *work, const sd_kalman_tables_t *t, sd_pattern_sums_t *sums) {
    sums->cycles += 1.0f;
    sums->u += work->u;
    sums->uu += work->u * work->u;
    sums->r += work->r;
    sums->rr += work->r * work->r;
    sums->ur += work->u * work->r;
    sums->late_common += work->r * work->late_common;
    sums->square += work->square / (float)t->teeth;
}

static bool finish_cycle(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_fit_t *fit) {
    count_cycle(&self->work, t, &self->sums);
    if (fit->cycles < (float)SD_PATTERN_CYCLES_MIN) { return false; }
    conclude(self, t, fit);
    return true;
}

/* Positions of the last cycle up to `most`, the last one not included. Returns true when the pattern changed: all are in. */
static bool work(sd_pattern_t *self, const sd_kalman_tables_t *t, uint32_t most) {
    sd_pattern_work_t *w = &self->work;
    if (w->next >= t->positions) { return false; }
    const sd_fit_t fit = fit_of(&self->sums, w, true);
    const bool places = fit.cycles >= (float)SD_PATTERN_CYCLES_MIN;
    for (; (w->next < most) && (w->next < t->positions); ++w->next) {
        const uint32_t k = w->next;
        if (!sd_kalman_has_tooth(t, k)) { continue; }
        const float late = late_of(self, t, k);
        self->sums.late[k] += late;
        self->sums.late_u[k] += w->u * late;
        w->square += late * late;
        w->late_common += late * common_late(t, k);
        if (places) { place_tooth(self, t, &fit, k); }
    }
    return (w->next >= t->positions) && finish_cycle(self, t, &fit);
}

void sd_pattern_keep(const sd_pattern_t *self, const sd_kalman_tables_t *t, sd_pattern_sums_t *sums) {
    *sums = self->sums;
    if (self->work.next >= t->positions) { return; }
    sd_pattern_work_t rest = self->work;
    for (uint32_t k = rest.next; k < t->positions; ++k) {
        if (!sd_kalman_has_tooth(t, k)) { continue; }
        const float late = late_of(self, t, k);
        sums->late[k] += late;
        sums->late_u[k] += rest.u * late;
        rest.square += late * late;
        rest.late_common += late * common_late(t, k);
    }
    count_cycle(&rest, t, sums);
}

/* ---- a cycle --------------------------------------------------------------------------------------------------- */

/* The trend a_1 k + a_2 k^2 from the differences between the two revolutions. */
static void find_trend(const sd_kalman_tables_t *t, const sd_teeth_sums_t *pairs, float *a1, float *a2) {
    const float n = (float)t->positions;
    float level, slope;
    sd_teeth_line(pairs, pairs->d, pairs->kd, &level, &slope);
    *a2 = slope / (2.0f * n);
    *a1 = level / n - 2.0f * n * *a2;
}

static float mean_charge(const sd_pattern_t *self, const sd_kalman_tables_t *t) {
    float sum = 0.0f;
    for (uint32_t i = 0; i < t->cylinders; ++i) { sum += self->charge.charge_bar[i]; }
    return sum / (float)t->cylinders;
}

/* The last cycle is good: it is put on its way into the sums. */
static void hand_on(sd_pattern_t *self, const sd_kalman_tables_t *t, float a1, float a2, float square_speed) {
    const sd_teeth_sums_t *p = &self->pairs;
    const float n = (float)t->positions;
    const float trend = a1 * (2.0f * p->k + 2.0f * n * p->count) + a2 * (2.0f * p->kk + 4.0f * n * p->k + 2.5f * n * n * p->count);
    const float u = W_REF_RADPS * W_REF_RADPS / square_speed;
    self->work = (sd_pattern_work_t){ .next = 0, .a1 = a1, .a2 = a2, .mean_rad = 0.5f * (p->a - trend) / p->count, .u = u,
                                      .r = u * mean_charge(self, t), .scale_nm = t->inertia_mean_kgm2 * square_speed,
                                      .exponent = self->exponent_next };
}

/* All teeth of a cycle are in: learn from it when the guess was good, and better the guess. */
static void end_cycle(sd_pattern_t *self, const sd_kalman_tables_t *t) {
    const float pitch = t->pitch_rad;
    float a1 = 0.0f, a2 = 0.0f;
    const bool settled = self->guessed >= ((t->modes > 0u) ? MODES_SETTLED : 2u);
    if (settled) {
        sd_twist_learn(&self->twist, t, &self->sums.twist, &self->pairs, &self->free);
        self->tuning = sd_twist_tuning(&self->sums.twist);
    }
    find_trend(t, &self->pairs, &a1, &a2);
    const float slope = a1 / pitch, bend = a2 / (pitch * pitch); /* a rad */
    const float square_speed = 2.0f * self->energy_j / t->inertia_mean_kgm2;
    self->ripple_nm = sd_root(1e-6f + self->ripple_square / (float)(2u * t->positions));
    const bool good = settled && (slope < SLOPE_MAX) && (slope > -SLOPE_MAX) && sd_twist_known(&self->twist, t);
    if (good) { hand_on(self, t, a1, a2, square_speed); }
    /* L' = -de / (2 e), and de grows by the constant torque's error. */
    const float constant = -4.0f * bend * self->energy_j;
    const float cycle_rad = 12.566371f;
    self->energy_j = self->free.energy_j - 2.0f * slope * self->energy_j + constant * cycle_rad;
    self->constant_nm += constant;
    if (self->guessed < 255u) { self->guessed++; }
}

/* From tooth 0: the free prediction starts with no lateness; the modes swing on. */
static void begin_cycle(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const float two_over_j = sd_motion_word(t, 0)[SD_ROW_TOOTH].value;
    if (self->guessed == 0u) {
        const float speed = t->pitch_rad * t->tick_hz * (float)tooth->advance / (float)tooth->period_ticks;
        self->energy_j = speed * speed / two_over_j;
        self->constant_nm = 0.0f;
        self->guessed = 1;
    }
    sd_motion_fill(&self->charge, tooth->intake_bar);
    self->free.lateness_s = 0.0f;
    self->free.energy_j = self->energy_j;
    self->free.coefficient_nm[0] = self->constant_nm;
    const float square = self->energy_j * two_over_j, speed = sd_sqrt_f32(square);
    self->free.lateness_s = sd_motion_late(&self->free, t, speed, &self->tuning) / speed;
    sd_twist_begin(&self->twist, t, &self->free, &self->tuning);
    memset(&self->pairs, 0, sizeof self->pairs);
    self->ripple_square = 0.0f;
    self->cycle_rad[0] = 0.0f;
    self->twist.sensitivity_rad[0] = 0.0f;
    self->teeth = 1;
    self->following = 1;
}

/* Both predictions over the intervals since the last tooth. False when the crank would stand still. */
static bool run_free(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const uint32_t cycle = 2u * t->positions;
    bool moving = (tooth->advance >= 1u) && (tooth->advance <= cycle);
    sd_motion_take_intake(&self->charge, tooth->intake_bar);
    for (uint32_t left = tooth->advance; (left > 0u) && moving;) {
        left--;
        const uint32_t ahead = tooth->cycle_position + cycle - left, k = (ahead >= cycle) ? ahead - cycle : ahead;
        sd_motion_row_t row;
        sd_motion_known(t, k, &self->charge, &row);
        self->ripple_square += row.mean_nm * row.mean_nm;
        moving = sd_motion_predict(&self->free, t, &row, 0.0f, &self->tuning) && sd_twist_predict(&self->twist, t, &row);
        sd_motion_close_valves(&self->charge, t, row.word);
    }
    return moving && (self->free.energy_j < 1e9f);
}

/* A tooth of the second revolution makes a pair with the same one in the first. Returns the difference. */
static float pair_up(sd_pattern_t *self, const sd_kalman_tables_t *t, uint32_t tooth, float late_rad) {
    const float first = self->cycle_rad[tooth], d = late_rad - first, at = (float)tooth - 0.5f * (float)t->positions;
    sd_teeth_sums_t *p = &self->pairs;
    p->count += 1.0f;
    p->k += at;
    p->kk += at * at;
    p->a += late_rad + first;
    p->d += d;
    p->kd += at * d;
    p->dd += d * d;
    return d;
}

/* The prediction went astray: so did the modes. */
static void give_up(sd_pattern_t *self) {
    sd_pattern_pause(self);
    memset(&self->free, 0, sizeof self->free);
    memset(&self->twist.trial, 0, sizeof self->twist.trial);
}

static void follow(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    if (!run_free(self, t, tooth)) { give_up(self); return; }
    const uint32_t k = tooth->cycle_position;
    const float period_s = (float)tooth->period_ticks / t->tick_hz;
    const float square = self->free.energy_j * sd_motion_word(t, k)[SD_ROW_TOOTH].value, speed = sd_sqrt_f32(square);
    self->free.lateness_s -= period_s;
    self->teeth++;
    if (k == 0u) { return; } /* tooth 0 again: its lateness closes the cycle, but belongs to the next one */
    const float late = sd_motion_late(&self->free, t, speed, &self->tuning);
    if (!sd_within(late, -LATE_MAX, LATE_MAX)) { give_up(self); return; }
    const float d = (k >= t->positions) ? pair_up(self, t, k - t->positions, late) : 0.0f;
    self->cycle_rad[k] = late;
    sd_twist_follow(&self->twist, t, k, period_s, late, d, &self->pairs);
}

bool sd_pattern_step(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const uint32_t k = tooth->cycle_position;
    if ((tooth->trusted == 0u) || (k >= 2u * t->positions) || (tooth->period_ticks == 0u) || !sd_within(tooth->intake_bar, 0.0f, 10.0f)) {
        return sd_pattern_rest(self, t);
    }
    /* Up to this tooth, whose place the cycle under way takes. */
    const uint32_t least = self->work.next + PIECE;
    const bool changed = work(self, t, ((k < t->positions) && (k >= least)) ? k + 1u : least);
    if (self->following != 0u) {
        follow(self, t, tooth);
        if ((self->following != 0u) && (k == 0u) && ((uint32_t)self->teeth == 2u * t->teeth + 1u)) { end_cycle(self, t); }
    }
    if (k == 0u) { begin_cycle(self, t, tooth); }
    return changed;
}

bool sd_pattern_rest(sd_pattern_t *self, const sd_kalman_tables_t *t) {
    sd_pattern_pause(self);
    return work(self, t, self->work.next + PIECE);
}

void sd_pattern_pause(sd_pattern_t *self) {
    self->following = 0;
    self->guessed = 0;
}

/* ---- zeros ----------------------------------------------------------------------------------------------------- */

bool sd_pattern_take_zero(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_firing_t *firing, float charge_bar,
                          float speed_radps) {
    const float u = W_REF_RADPS * W_REF_RADPS / (speed_radps * speed_radps), weight = u * u;
    if ((firing->index >= t->firings) || !(charge_bar > 0.05f) || !(weight < 1e4f)) { return false; }
    self->sums.zero[firing->index] += weight * firing->raw_nm / charge_bar;
    self->sums.zero_u2[firing->index] += weight;
    return firing->index == (t->firings - 1u);
}

void sd_pattern_zeros(const sd_pattern_t *self, const sd_kalman_tables_t *t, float *zero_nm_per_bar) {
    float mean = 0.0f;
    memset(zero_nm_per_bar, 0, SD_KALMAN_FIRINGS_MAX * sizeof *zero_nm_per_bar);
    for (uint32_t i = 0; i < t->firings; ++i) {
        if (!(self->sums.zero_u2[i] > 0.0f)) { return; }
        mean += self->sums.zero[i] / self->sums.zero_u2[i] / (float)t->firings;
    }
    for (uint32_t i = 0; i < t->firings; ++i) { zero_nm_per_bar[i] = self->sums.zero[i] / self->sums.zero_u2[i] - mean; }
}

/* ---- start ----------------------------------------------------------------------------------------------------- */

void sd_pattern_init(sd_pattern_t *self, const sd_kalman_tables_t *tables) {
    memset(self, 0, sizeof *self);
    self->work.next = tables->positions;
    self->exponent_sd = EXPONENT_SD;
    sd_motion_fill(&self->charge, 1.0f);
    sd_twist_init(&self->twist, tables, &self->sums.twist);
    self->tuning = sd_twist_tuning(&self->sums.twist);
}

static bool sums_ok(const sd_pattern_sums_t *sums, const sd_kalman_tables_t *t) {
    const float *value = (const float *)sums;
    bool ok = (sums->cycles >= 0.0f) && (sums->uu >= 0.0f) && (sums->square >= 0.0f) && sd_twist_sums_ok(&sums->twist, t) &&
        sd_fired_sums_ok(&sums->fired, t);
    for (uint32_t i = 0; i < sizeof *sums / sizeof *value; ++i) { ok = ok && (value[i] > -1e9f) && (value[i] < 1e9f); }
    for (uint32_t k = 0; k < t->positions; ++k) { ok = ok && (sd_kalman_has_tooth(t, k) || (sums->late[k] == 0.0f)); }
    return ok;
}

/* Rms of the motored torque at one bar. */
static float ripple_at_start(const sd_pattern_t *self, const sd_kalman_tables_t *t) {
    float square = 1e-6f;
    for (uint32_t k = 0; k < 2u * t->positions; ++k) {
        sd_motion_row_t row;
        sd_motion_known(t, k, &self->charge, &row);
        square += row.mean_nm * row.mean_nm / (float)(2u * t->positions);
    }
    return sd_root(square);
}

/* The pattern from the sums, with an exponent taken out. */
static void place_all(sd_pattern_t *self, const sd_kalman_tables_t *t, float exponent, float scale_nm) {
    self->work = (sd_pattern_work_t){ .next = t->positions, .exponent = exponent, .scale_nm = scale_nm };
    const sd_fit_t fit = fit_of(&self->sums, &self->work, false);
    for (uint32_t k = 0; k < t->positions; ++k) { place_tooth(self, t, &fit, k); }
    conclude(self, t, &fit);
}

sd_result_t sd_pattern_resume(sd_pattern_t *self, const sd_kalman_tables_t *t, const sd_pattern_sums_t *sums) {
    if (!sums_ok(sums, t)) { return SD_ERR_CONFIG; }
    sd_pattern_pause(self);
    self->sums = *sums;
    self->work.next = t->positions;
    self->tuning = sd_twist_tuning(&self->sums.twist);
    sd_motion_fill(&self->charge, 1.0f);
    self->ripple_nm = ripple_at_start(self, t);
    if (sums->cycles < (float)SD_PATTERN_CYCLES_MIN) { return SD_OK; }
    const float scale_nm = t->inertia_mean_kgm2 * W_REF_RADPS * W_REF_RADPS * sums->cycles / sums->u;
    self->exponent_next = 0.0f;
    for (uint32_t round = 0; round < RESUME_ROUNDS; ++round) { place_all(self, t, self->exponent_next, scale_nm); }
    return SD_OK;
}
