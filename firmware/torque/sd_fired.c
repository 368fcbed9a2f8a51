/* SPDX-License-Identifier: MIT */
#include "sd_fired.h"

#include <string.h>

#define LATE_MAX     0.3f    /* rad: beyond it, what is taken out is no longer linear */
#define FAILS        0.5f    /* of the mean torque: a firing that is off by more than this fails, or the filter follows a change */
#define SLOPE_SD     0.015f  /* rad over psi: what a pulse by other laws makes of a tooth */
#define UNSEEN_RAD   3.5e-5f /* 0.002 deg: no wheel is known better */
#define FIRST_RAD2   1e-7f   /* variance of a tooth in a cycle before one is measured: 0.02 deg */
#define READING_SD   0.05f   /* of the mean torque: a cycle's firings by themselves */
#define STEADY       1u      /* cycles after a change of fuel that tell nothing of hidden directions */
#define STEADY_FUEL  0.03f
#define PLACED_EACH  8.0f    /* of the cycles one more: the pattern is placed anew, */
#define PLACED_MOST  8u      /* or after so many */

#if SD_CYLINDERS_MAX == 8
_Static_assert(sizeof(sd_fired_t) == 2132, "without pointers, the same size on every target");
#endif

/* ---- tables ---------------------------------------------------------------------------------------------------- */

#define COLUMN (1.0f / 32767.0f) /* entries of Q are 16 bits */
#define PART_SHIFT 3               /* 240 products of halves fit 32 bits over 2^PART_SHIFT */
#define PART   (8.0f * COLUMN)     /* a whole number of Q' L, over SD_FIRED_UNIT_RAD */

/* The parts at tooth k, each in the first and in the second revolution. */
static const sd_kalman_word_t *columns_at(const sd_kalman_tables_t *t, uint32_t k) {
    return &t->pool[2u * t->positions * t->row_words + k * t->parts];
}

static const sd_kalman_word_t *restore_of(const sd_kalman_tables_t *t) { return columns_at(t, t->positions); }

static const sd_kalman_word_t *hidden_of(const sd_kalman_tables_t *t, uint32_t i) {
    return restore_of(t) + t->parts * t->parts + i * sd_motion_hidden_words(t);
}

static float times(const sd_kalman_word_t *word, const float *x, uint32_t count) {
    float sum = 0.0f;
    for (uint32_t j = 0; j < count; ++j) { sum += word[j].value * x[j]; }
    return sum;
}

static sd_pair_t pair_of(const sd_kalman_word_t *word) {
    sd_pair_t pair;
    memcpy(&pair, word, sizeof pair);
    return pair;
}

static const sd_pair_t ONES = { { 1, 1 } };

/* Sum of the entries of both revolutions. */
static int32_t both(const sd_kalman_word_t *word) { return sd_dot_pair(pair_of(word), ONES); }

/* ---- hidden directions ----------------------------------------------------------------------------------------- */

static float square(float x) { return x * x; }

/* What stands of a direction behind its torque over the firings. */
enum { SPREAD, SIZE, DOUBT };

static const sd_kalman_word_t *traits_of(const sd_kalman_tables_t *t, uint32_t i) { return hidden_of(t, i) + 2u * t->parts + t->firings; }

/* What a direction that is not learned may hold: as much as any other of such a wheel. */
static float prior_of(const sd_fired_t *self) {
    const float found = sd_fired_used(self)->found_rad;
    return (found > self->unlearned_rad) ? found : self->unlearned_rad;
}

/* Whether the cycle tells of hidden directions. */
static bool tells_hidden(const sd_fired_t *self, const sd_fired_cycle_t *cycle) {
    return (sd_fired_used(self)->sd_rad > 0.0f) && (cycle->steady != 0u) && (cycle->fuel_mg > 0.0f) && (cycle->psi > 0.0f);
}

/* What a cycle says of direction i: the firings as the filter had them, and what the cycle shows of them beside that. */
static void read_hidden(const sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_cycle_t *cycle, const int32_t *part, uint32_t i,
                        sd_hidden_t *hidden) {
    const sd_kalman_word_t *parts = hidden_of(t, i) + t->parts, *firings = parts + t->parts, *traits = traits_of(t, i);
    const float scale = cycle->scale_nm;
    sd_hidden_reading_t reading = { .fuel_mg = cycle->fuel_mg, .charge_bar = cycle->charge_bar, .mean_nm = cycle->psi * scale,
                                    .scale_nm = scale, .speed_radps = sd_root(scale / t->inertia_mean_kgm2) };
    float seen = 0.0f, noise = 0.0f;
    for (uint32_t j = 0; j < t->parts; ++j) {
        seen += parts[j].value * ((float)part[j] * (PART * SD_FIRED_UNIT_RAD) - self->task.known[j]);
        noise += square(parts[j].value);
    }
    reading.z_nm = times(firings, cycle->firing_nm, t->firings) + scale * seen;
    reading.variance = square(READING_SD * traits[SIZE].value * reading.mean_nm) / (float)t->firings +
        2.0f * square(scale) * noise * self->task.left_rad2;
    sd_hidden_step(hidden, &reading, traits[SIZE].value, traits[DOUBT].value, i == 0u, prior_of(self));
}

/* ---- the task: a cycle goes into the sums ----------------------------------------------------------------------- */

/* Q' L in whole numbers of SD_FIRED_UNIT_RAD PART. */
static void find_parts(const sd_kalman_tables_t *t, const sd_fired_cycle_t *cycle, int32_t *part) {
    for (uint32_t j = 0; j < t->parts; ++j) {
        const sd_kalman_word_t *column = columns_at(t, 0) + j; /* 0 where there is no tooth */
        int64_t sum = 0;
        _Pragma("GCC unroll 4")
        for (uint32_t k = 0; k < t->positions; ++k, column += t->parts) { sum = sd_dot_pairs(sum, pair_of(column), cycle->late[k]); }
        part[j] = (int32_t)(sum >> PART_SHIFT);
    }
}

static void sum_cycle(const sd_kalman_tables_t *t, const sd_fired_cycle_t *cycle, const int32_t *part, sd_fired_sums_t *s) {
    const float psi = cycle->psi;
    float sum = 0.0f;
    for (uint32_t k = 0; k < t->positions; ++k) {
        if (!sd_kalman_has_tooth(t, k)) { continue; }
        const sd_kalman_word_t *column = columns_at(t, k);
        int64_t taken = 0;
        _Pragma("GCC unroll 4")
        for (uint32_t j = 0; j < t->parts; ++j) { taken += (int64_t)both(&column[j]) * part[j]; }
        const float seen = (float)sd_dot_pair(cycle->late[k], ONES);
        const float late = (0.5f * SD_FIRED_UNIT_RAD) * (seen - (float)(int32_t)(taken >> 18) * (262144.0f * PART * COLUMN));
        s->late[k] += late;
        s->late_psi[k] += psi * late;
        sum += late * late;
    }
    s->cycles += 1.0f;
    s->psi += psi;
    s->psi2 += psi * psi;
    s->square += sum / (float)t->teeth;
}

/* ---- the task: the pattern comes out of the sums ----------------------------------------------------------------- */

/* How the sums tell pattern from slope: the pattern is `late` late + `psi` late_psi. */
typedef struct sd_fired_fit { float late, psi, psi2; } sd_fired_fit_t;

/* v: variance that the fit leaves of a tooth in a cycle. */
static sd_fired_fit_t weigh(const sd_fired_sums_t *s, float v) {
    const float psi2 = s->psi2 + v / (SLOPE_SD * SLOPE_SD), over = 1.0f / (s->cycles * psi2 - s->psi * s->psi);
    return (sd_fired_fit_t){ psi2 * over, -s->psi * over, s->cycles * over };
}

/* What of the pattern comes from torque, over the columns of `both`: what was taken out of m, and hidden directions. m stands in
 * `late_rad`. */
static void restore(sd_fired_task_t *task, const sd_kalman_tables_t *t, const sd_fired_sums_t *s, const float *late_rad, float *part) {
    float of_late[SD_KALMAN_PARTS_MAX] = { 0.0f };
    for (uint32_t k = 0; k < t->positions; ++k) {
        const sd_kalman_word_t *column = columns_at(t, k);
        for (uint32_t j = 0; j < t->parts; ++j) { of_late[j] += (float)both(&column[j]) * late_rad[k]; }
    }
    for (uint32_t j = 0; j < t->parts; ++j) { of_late[j] *= 0.5f * COLUMN; }
    for (uint32_t j = 0; j < t->parts; ++j) {
        part[j] = task->known[j] = times(restore_of(t) + j * t->parts, of_late, t->parts);
        for (uint32_t i = 0; i < t->hidden; ++i) { part[j] += hidden_of(t, i)[j].value * s->hidden[i].x[SD_HIDDEN_PATTERN]; }
        part[j] *= 0.5f * COLUMN;
    }
}

/* Deviations of a pattern in place. explained: what it and the slope explain of the sums. */
static void judge(const sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *s, const sd_fired_fit_t *fit, float explained,
                  sd_fired_task_t *task, sd_fired_pattern_t *pattern) {
    const float teeth = (float)t->teeth, left = (s->square - explained / teeth) / (s->cycles - 2.0f);
    task->left_rad2 = (left > 1e-12f) ? left : 1e-12f;
    float hidden = 0.0f, firings = 0.0f;
    for (uint32_t i = 0; i < t->hidden; ++i) {
        const float variance = sd_hidden_variance(&s->hidden[i], prior_of(self));
        hidden += variance / teeth;
        firings += variance * square(traits_of(t, i)[SPREAD].value);
    }
    pattern->tooth_rad = sd_root(task->left_rad2 * fit->late + UNSEEN_RAD * UNSEEN_RAD);
    pattern->sd_rad = sd_root(square(pattern->tooth_rad) + hidden);
    pattern->hidden_share = sd_root(firings);
    pattern->cycles = s->cycles;
}

/* The pattern that is not in use becomes what the sums say. */
static void place_pattern(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *s) {
    sd_fired_pattern_t *coming = &self->pattern[self->used ^ 1u];
    const sd_fired_fit_t fit = weigh(s, self->task.left_rad2);
    float part[SD_KALMAN_PARTS_MAX], explained = 0.0f, sum = 0.0f;
    for (uint32_t k = 0; k < t->positions; ++k) {
        const float constant = fit.late * s->late[k] + fit.psi * s->late_psi[k], slope = fit.psi * s->late[k] + fit.psi2 * s->late_psi[k];
        explained += constant * s->late[k] + slope * s->late_psi[k];
        coming->late_rad[k] = constant;
    }
    restore(&self->task, t, s, coming->late_rad, part);
    for (uint32_t k = 0; k < t->positions; ++k) {
        const sd_kalman_word_t *column = columns_at(t, k);
        float late = coming->late_rad[k];
        for (uint32_t j = 0; j < t->parts; ++j) { late += (float)both(&column[j]) * part[j]; }
        coming->late_rad[k] = late;
        sum += late * late;
    }
    coming->found_rad = sd_root(sum / (float)t->teeth);
    judge(self, t, s, &fit, explained, &self->task, coming);
    self->task.since = 0;
    self->task.placed = 1;
}

/* ---- the task ---------------------------------------------------------------------------------------------------- */

void sd_fired_hand_over(sd_fired_t *self) { self->handed = self->waits; }

void sd_fired_work(sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *sums) {
    if (self->handed == 0u) { return; }
    const sd_fired_cycle_t *cycle = &self->cycle[self->collects ^ 1u];
    int32_t part[SD_KALMAN_PARTS_MAX];
    find_parts(t, cycle, part);
    for (uint32_t i = 0; (i < t->hidden) && tells_hidden(self, cycle); ++i) { read_hidden(self, t, cycle, part, i, &sums->hidden[i]); }
    sum_cycle(t, cycle, part, sums);
    self->task.since++;
    if (sums->cycles < (float)SD_FIRED_CYCLES_MIN) { return; }
    if ((self->task.since >= PLACED_MOST) || (PLACED_EACH * (float)self->task.since >= sums->cycles)) { place_pattern(self, t, sums); }
}

bool sd_fired_take_over(sd_fired_t *self) {
    const bool changed = self->task.placed != 0u;
    if (self->handed != 0u) { self->waits = 0; }
    self->handed = 0;
    if (changed) { self->used ^= 1u; }
    self->task.placed = 0;
    return changed;
}

/* ---- teeth: the cycle under way ---------------------------------------------------------------------------------- */

/* From tooth 0: the free estimate starts with no lateness and what the filter knows. */
static void begin_cycle(sd_fired_t *self, const sd_kalman_tables_t *t, sd_kalman_t *kalman, float fuel_mg) {
    sd_fired_cycle_t *cycle = &self->cycle[self->collects];
    sd_kalman_set_free(kalman);
    const float *coefficient_nm = &kalman->free.coefficient_nm[1];
    float sum = 0.0f, charge = 0.0f;
    for (uint32_t j = 0; j < t->firings; ++j) { sum += cycle->firing_nm[j] = coefficient_nm[j]; }
    for (uint32_t j = 0; j < t->cylinders; ++j) { charge += kalman->charge.charge_bar[j]; }
    cycle->scale_nm = t->inertia_mean_kgm2 * kalman->free.energy_j * sd_motion_word(t, 0)[SD_ROW_TOOTH].value;
    cycle->psi = sum / ((float)t->firings * cycle->scale_nm);
    cycle->charge_bar = charge / (float)t->cylinders;
    cycle->fuel_mg = fuel_mg;
    cycle->late[0].half[0] = 0;
    const bool same = __builtin_fabsf(fuel_mg - self->fuel_mg) <= STEADY_FUEL * self->fuel_mg;
    self->steady = !same ? 0u : (self->steady < 255u) ? (uint8_t)(self->steady + 1u) : self->steady;
    self->fuel_mg = fuel_mg;
    self->teeth = 1;
    self->following = 1;
}

/* A lateness in whole units, rounded to the nearest; what it is within makes it fit. */
static int16_t units_of(float late_rad) {
    return (int16_t)((int32_t)(late_rad * (1.0f / SD_FIRED_UNIT_RAD) + 32768.5f) - 32768);
}

static void follow(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_kalman_t *kalman, uint32_t k) {
    self->teeth++;
    if (k == 0u) { return; } /* tooth 0 again: its lateness belongs to the next cycle */
    const sd_motion_t *free = &kalman->free;
    const float square_speed = free->energy_j * sd_motion_word(t, k)[SD_ROW_TOOTH].value;
    const float late = -free->lateness_s * sd_sqrt_f32(square_speed);
    if (!sd_within(late, -LATE_MAX, LATE_MAX)) { self->following = 0; return; }
    sd_fired_cycle_t *cycle = &self->cycle[self->collects];
    const bool second = k >= t->positions;
    cycle->late[second ? k - t->positions : k].half[second ? 1 : 0] = units_of(late);
}

/* Whether every firing was as the filter had it, by and large. */
static bool steady_firings(const sd_fired_cycle_t *cycle, const sd_kalman_tables_t *t, const sd_kalman_t *kalman) {
    const float *now = kalman->filter[kalman->believed].motion.coefficient_nm, most = FAILS * cycle->psi * cycle->scale_nm;
    bool steady = true;
    for (uint32_t j = 0; j < t->firings; ++j) { steady = steady && (__builtin_fabsf(now[1u + j] - cycle->firing_nm[j]) < most); }
    return steady;
}

/* All teeth of a cycle are in. */
static void end_cycle(sd_fired_t *self) {
    self->cycle[self->collects].steady = (self->steady >= STEADY) ? 1u : 0u;
    if (self->waits != 0u) { return; }
    self->waits = 1;
    self->collects ^= 1u;
}

void sd_fired_step(sd_fired_t *self, const sd_kalman_tables_t *t, sd_kalman_t *kalman, uint32_t cycle_position, float fuel_mg,
                   bool corrected) {
    if ((t->parts == 0u) || (cycle_position >= 2u * t->positions)) { return; }
    if (!corrected) { self->steady = 0; }
    if (kalman->free_runs == 0u) { self->following = 0; }
    if (self->following != 0u) { follow(self, t, kalman, cycle_position); }
    if (cycle_position != 0u) { return; }
    const bool whole = (self->following != 0u) && ((uint32_t)self->teeth == 2u * t->teeth + 1u);
    if (whole && steady_firings(&self->cycle[self->collects], t, kalman)) { end_cycle(self); }
    begin_cycle(self, t, kalman, fuel_mg);
}

void sd_fired_rest(sd_fired_t *self, sd_kalman_t *kalman) {
    self->following = 0;
    kalman->free_runs = 0;
}

/* ---- start ----------------------------------------------------------------------------------------------------- */

static void forget(sd_fired_t *self) {
    const float unlearned_rad = self->unlearned_rad;
    memset(self, 0, sizeof *self);
    self->unlearned_rad = unlearned_rad;
    self->task.left_rad2 = FIRST_RAD2;
}

void sd_fired_init(sd_fired_t *self) {
    self->unlearned_rad = 0.0f;
    forget(self);
}

bool sd_fired_sums_ok(const sd_fired_sums_t *sums, const sd_kalman_tables_t *t) {
    bool ok = (sums->cycles >= 0.0f) && (sums->psi2 >= 0.0f) && (sums->square >= 0.0f) && ((t->parts != 0u) || !(sums->cycles > 0.0f));
    for (uint32_t k = 0; k < t->positions; ++k) {
        ok = ok && (sd_kalman_has_tooth(t, k) || ((sums->late[k] == 0.0f) && (sums->late_psi[k] == 0.0f)));
    }
    for (uint32_t i = 0; i < SD_KALMAN_HIDDEN_MAX; ++i) { ok = ok && sd_hidden_ok(&sums->hidden[i]); }
    return ok;
}

void sd_fired_resume(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *sums) {
    forget(self);
    if ((t->parts == 0u) || (sums->cycles < (float)SD_FIRED_CYCLES_MIN)) { return; }
    for (uint32_t round = 0; round < 2u; ++round) { /* the second by the variance that the first one found */
        place_pattern(self, t, sums);
        (void)sd_fired_take_over(self);
    }
}
