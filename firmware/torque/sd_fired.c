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

#if SD_CYLINDERS_MAX == 8
_Static_assert(sizeof(sd_fired_t) == 896, "without pointers, the same size on every target");
#endif

/* ---- tables ---------------------------------------------------------------------------------------------------- */

#define COLUMN (1.0f / 32767.0f) /* entries of Q are 16 bits */

static const int16_t *columns_at(const sd_kalman_tables_t *t, uint32_t k) {
    return sd_motion_word(t, k)[t->row_words - (t->parts + 1u) / 2u].gain;
}

static const sd_kalman_word_t *restore_of(const sd_kalman_tables_t *t) { return &t->pool[2u * t->positions * t->row_words]; }

static const sd_kalman_word_t *hidden_of(const sd_kalman_tables_t *t, uint32_t i) {
    return restore_of(t) + t->parts * t->parts + i * sd_motion_hidden_words(t);
}

static float times(const sd_kalman_word_t *word, const float *x, uint32_t count) {
    float sum = 0.0f;
    for (uint32_t j = 0; j < count; ++j) { sum += word[j].value * x[j]; }
    return sum;
}

/* ---- hidden directions ----------------------------------------------------------------------------------------- */

static float square(float x) { return x * x; }

/* What stands of a direction behind its torque over the firings. */
enum { SPREAD, SIZE, DOUBT };

static const sd_kalman_word_t *traits_of(const sd_kalman_tables_t *t, uint32_t i) { return hidden_of(t, i) + 2u * t->parts + t->firings; }

/* What a direction that is not learned may hold: as much as any other of such a wheel. */
static float prior_of(const sd_fired_t *self) { return (self->found_rad > self->unlearned_rad) ? self->found_rad : self->unlearned_rad; }

/* Whether the cycle tells of hidden directions. */
static bool tells_hidden(const sd_fired_t *self) {
    return (self->sd_rad > 0.0f) && (self->steady >= STEADY) && (self->fuel_mg > 0.0f) && (self->psi > 0.0f);
}

/* What a cycle says of direction i: the firings as the filter had them, and what the cycle shows of them beside that. */
static void read_hidden(const sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *sums, uint32_t i) {
    const sd_kalman_word_t *parts = hidden_of(t, i) + t->parts, *firings = parts + t->parts, *traits = traits_of(t, i);
    sd_hidden_reading_t reading = { .fuel_mg = self->fuel_mg, .mean_nm = self->psi * self->scale_nm, .scale_nm = self->scale_nm,
                                    .speed_radps = sd_root(self->scale_nm / t->inertia_mean_kgm2) };
    float part[SD_KALMAN_PARTS_MAX], noise = 0.0f, charge = 0.0f;
    for (uint32_t j = 0; j < t->parts; ++j) {
        part[j] = self->part[j] - self->known[j];
        noise += square(parts[j].value);
    }
    for (uint32_t j = 0; j < t->cylinders; ++j) { charge += self->charge.charge_bar[j]; }
    reading.charge_bar = charge / (float)t->cylinders;
    reading.z_nm = times(firings, &self->free.coefficient_nm[1], t->firings) + self->scale_nm * times(parts, part, t->parts);
    reading.variance = square(READING_SD * traits[SIZE].value * reading.mean_nm) / (float)t->firings +
        2.0f * square(self->scale_nm) * noise * self->left_rad2;
    sd_hidden_step(&sums->hidden[i], &reading, traits[SIZE].value, traits[DOUBT].value, i == 0u, prior_of(self));
}

/* ---- the last cycle goes into the sums, and the pattern comes out of them ------------------------------------------ */

/* How the sums tell pattern from slope; v: variance that the fit leaves of a tooth in a cycle. */
static void weigh(sd_fired_work_t *w, const sd_fired_sums_t *s, float v) {
    const float psi2 = s->psi2 + v / (SLOPE_SD * SLOPE_SD), over = 1.0f / (s->cycles * psi2 - s->psi * s->psi);
    w->weight = psi2 * over;
    w->weight_psi = -s->psi * over;
    w->weight_psi2 = s->cycles * over;
}

/* From here on the pattern is placed. */
static void begin_placing(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *s) {
    sd_fired_work_t *w = &self->work;
    float constant[SD_KALMAN_PARTS_MAX];
    weigh(w, s, self->left_rad2);
    for (uint32_t j = 0; j < t->parts; ++j) { constant[j] = w->weight * s->part[j] + w->weight_psi * s->part_psi[j]; }
    for (uint32_t j = 0; j < t->parts; ++j) {
        w->part[j] = self->known[j] = times(restore_of(t) + j * t->parts, constant, t->parts);
        for (uint32_t i = 0; i < t->hidden; ++i) { w->part[j] += hidden_of(t, i)[j].value * s->hidden[i].x[SD_HIDDEN_PATTERN]; }
    }
    w->next = 0;
    w->phase = SD_FIRED_PLACES;
    w->square = w->explained = 0.0f;
}

static void place_tooth(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *s, uint32_t k) {
    sd_fired_work_t *w = &self->work;
    const int16_t *first = columns_at(t, k), *second = columns_at(t, k + t->positions);
    const float constant = w->weight * s->late[k] + w->weight_psi * s->late_psi[k],
        slope = w->weight_psi * s->late[k] + w->weight_psi2 * s->late_psi[k];
    float late = constant;
    for (uint32_t j = 0; j < t->parts; ++j) { late += (float)(first[j] + second[j]) * (0.5f * COLUMN) * w->part[j]; }
    self->late_rad[k] = late;
    w->square += late * late;
    w->explained += constant * s->late[k] + slope * s->late_psi[k];
}

static void conclude(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *s) {
    const sd_fired_work_t *w = &self->work;
    const float teeth = (float)t->teeth, left = (s->square - w->explained / teeth) / (s->cycles - 2.0f);
    self->left_rad2 = (left > 1e-12f) ? left : 1e-12f;
    float hidden = 0.0f, firings = 0.0f;
    self->found_rad = sd_root(w->square / teeth);
    for (uint32_t i = 0; i < t->hidden; ++i) {
        const float variance = sd_hidden_variance(&s->hidden[i], prior_of(self));
        hidden += variance / teeth;
        firings += variance * square(traits_of(t, i)[SPREAD].value);
    }
    self->tooth_rad = sd_root(self->left_rad2 * w->weight + UNSEEN_RAD * UNSEEN_RAD);
    self->sd_rad = sd_root(self->tooth_rad * self->tooth_rad + hidden);
    self->hidden_share = sd_root(firings);
}

static void sum_tooth(sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *s, const float *cycle_rad, uint32_t k) {
    sd_fired_work_t *w = &self->work;
    const int16_t *first = columns_at(t, k), *second = columns_at(t, k + t->positions);
    float both[SD_KALMAN_PARTS_MAX], late = 0.5f * (cycle_rad[k] + cycle_rad[k + t->positions]);
    for (uint32_t j = 0; j < t->parts; ++j) {
        both[j] = (float)(first[j] + second[j]) * (0.5f * COLUMN);
        late -= both[j] * self->part[j];
    }
    for (uint32_t j = 0; j < t->parts; ++j) { w->of_late[j] += both[j] * late; }
    s->late[k] += late;
    s->late_psi[k] += self->psi * late;
    w->square += late * late;
}

static void count_cycle(sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *s) {
    const float *of_late = self->work.of_late, psi = self->psi;
    s->cycles += 1.0f;
    s->psi += psi;
    s->psi2 += psi * psi;
    s->square += self->work.square / (float)t->teeth;
    for (uint32_t j = 0; j < t->parts; ++j) {
        s->part[j] += of_late[j];
        s->part_psi[j] += psi * of_late[j];
    }
    self->work.phase = (s->cycles >= (float)SD_FIRED_CYCLES_MIN) ? SD_FIRED_WEIGHS : SD_FIRED_RESTS;
}

/* The next position that has a tooth, or N. */
static uint32_t next_tooth(sd_fired_work_t *w, const sd_kalman_tables_t *t) {
    while ((w->next < t->positions) && !sd_kalman_has_tooth(t, w->next)) { w->next++; }
    return w->next++;
}

/* A piece of the work. Returns true when the pattern changed. */
static bool work(sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *sums, const float *cycle_rad) {
    sd_fired_work_t *w = &self->work;
    if (w->phase == (uint8_t)SD_FIRED_READS) {
        read_hidden(self, t, sums, w->next++);
        if (w->next >= t->hidden) { w->next = 0; w->phase = SD_FIRED_SUMS; }
    } else if (w->phase == (uint8_t)SD_FIRED_SUMS) {
        const uint32_t k = next_tooth(w, t);
        if (k < t->positions) { sum_tooth(self, t, sums, cycle_rad, k); } else { count_cycle(self, t, sums); }
    } else if (w->phase == (uint8_t)SD_FIRED_WEIGHS) {
        begin_placing(self, t, sums);
    } else if (w->phase == (uint8_t)SD_FIRED_PLACES) {
        const uint32_t k = next_tooth(w, t);
        if (k < t->positions) { place_tooth(self, t, sums, k); return false; }
        conclude(self, t, sums);
        w->phase = SD_FIRED_RESTS;
        return true;
    }
    return false;
}

/* ---- the cycle under way --------------------------------------------------------------------------------------- */

/* From tooth 0: the free prediction starts with no lateness and what the filter knows. */
static void begin_cycle(sd_fired_t *self, const sd_kalman_tables_t *t, float *cycle_rad, const sd_kalman_t *kalman, float fuel_mg) {
    const sd_kalman_filter_t *filter = &kalman->filter[kalman->believed];
    float sum = 0.0f;
    for (uint32_t j = 1; j <= t->firings; ++j) { sum += filter->motion.coefficient_nm[j]; }
    self->free = filter->motion;
    self->free.lateness_s = 0.0f;
    self->charge = kalman->charge;
    self->scale_nm = t->inertia_mean_kgm2 * self->free.energy_j * sd_motion_word(t, 0)[SD_ROW_TOOTH].value;
    self->psi = sum / ((float)t->firings * self->scale_nm);
    const bool same = __builtin_fabsf(fuel_mg - self->fuel_mg) <= STEADY_FUEL * self->fuel_mg;
    self->steady = !same ? 0u : (self->steady < 255u) ? (uint8_t)(self->steady + 1u) : self->steady;
    self->fuel_mg = fuel_mg;
    memset(self->part, 0, sizeof self->part);
    cycle_rad[0] = 0.0f;
    self->teeth = 1;
    self->following = 1;
}

/* The prediction over the intervals since the last tooth. False when the crank would stand still. */
static bool run_free(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const sd_motion_tuning_t rigid = { 1.0f, 1.0f, 1.0f };
    const uint32_t cycle = 2u * t->positions;
    bool moving = (tooth->advance >= 1u) && (tooth->advance <= cycle);
    sd_motion_take_intake(&self->charge, tooth->intake_bar);
    for (uint32_t left = tooth->advance; (left > 0u) && moving;) {
        left--;
        const uint32_t ahead = tooth->cycle_position + cycle - left, k = (ahead >= cycle) ? ahead - cycle : ahead;
        sd_motion_row_t row;
        sd_motion_known(t, k, &self->charge, &row);
        moving = sd_motion_predict(&self->free, t, &row, 0.0f, &rigid);
        sd_motion_close_valves(&self->charge, t, row.word);
    }
    self->free.lateness_s -= (float)tooth->period_ticks / t->tick_hz;
    return moving && (self->free.energy_j < 1e9f);
}

static void follow(sd_fired_t *self, const sd_kalman_tables_t *t, float *cycle_rad, const sd_kalman_tooth_t *tooth) {
    const uint32_t k = tooth->cycle_position;
    if (!run_free(self, t, tooth)) { self->following = 0; return; }
    self->teeth++;
    if (k == 0u) { return; } /* tooth 0 again: its lateness belongs to the next cycle */
    const float speed = sd_sqrt_f32(self->free.energy_j * sd_motion_word(t, k)[SD_ROW_TOOTH].value), late = -self->free.lateness_s * speed;
    if (!sd_within(late, -LATE_MAX, LATE_MAX)) { self->following = 0; return; }
    cycle_rad[k] = late;
    const int16_t *column = columns_at(t, k);
    for (uint32_t j = 0; j < t->parts; ++j) { self->part[j] += (float)column[j] * (late * COLUMN); }
}

/* Whether every firing was as the filter had it, by and large. */
static bool steady_firings(const sd_fired_t *self, const sd_kalman_tables_t *t, const sd_kalman_t *kalman) {
    const float *now = kalman->filter[kalman->believed].motion.coefficient_nm, *then = self->free.coefficient_nm;
    const float most = FAILS * self->psi * self->scale_nm;
    bool steady = true;
    for (uint32_t j = 1; j <= t->firings; ++j) { steady = steady && (__builtin_fabsf(now[j] - then[j]) < most); }
    return steady;
}

/* All teeth of a cycle are in. */
static void end_cycle(sd_fired_t *self, const sd_kalman_tables_t *t) {
    memset(&self->work, 0, sizeof self->work);
    self->work.phase = (tells_hidden(self) && (t->hidden > 0u)) ? SD_FIRED_READS : SD_FIRED_SUMS;
    self->pause = 1;
}

/* What the last cycle left is in the sums, so that another one may be seen. */
static bool has_time(sd_fired_t *self) {
    if (self->pause > 0u) { self->pause--; return false; }
    return (self->work.phase == (uint8_t)SD_FIRED_RESTS) || (self->work.phase == (uint8_t)SD_FIRED_PLACES);
}

bool sd_fired_step(sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *sums, float *cycle_rad, const sd_kalman_t *kalman,
                   const sd_kalman_tooth_t *tooth, float fuel_mg, bool corrected, bool burdened) {
    if (t->parts == 0u) { return false; }
    if (!corrected) { self->steady = 0; }
    const bool changed = !burdened && work(self, t, sums, cycle_rad);
    if (self->following != 0u) { follow(self, t, cycle_rad, tooth); }
    if (tooth->cycle_position != 0u) { return changed; }
    const bool whole = (self->following != 0u) && ((uint32_t)self->teeth == 2u * t->teeth + 1u);
    self->following = 0;
    if (whole && steady_firings(self, t, kalman)) {
        end_cycle(self, t);
    } else if (has_time(self)) {
        begin_cycle(self, t, cycle_rad, kalman, fuel_mg);
    }
    return changed;
}

bool sd_fired_rest(sd_fired_t *self, const sd_kalman_tables_t *t, sd_fired_sums_t *sums, const float *cycle_rad) {
    self->following = 0;
    return (t->parts != 0u) && work(self, t, sums, cycle_rad);
}

/* ---- start ----------------------------------------------------------------------------------------------------- */

static void forget(sd_fired_t *self) {
    const float unlearned_rad = self->unlearned_rad;
    memset(self, 0, sizeof *self);
    self->unlearned_rad = unlearned_rad;
    self->left_rad2 = FIRST_RAD2;
}

void sd_fired_init(sd_fired_t *self) {
    self->unlearned_rad = 0.0f;
    forget(self);
}

bool sd_fired_sums_ok(const sd_fired_sums_t *sums, const sd_kalman_tables_t *t) {
    bool ok = (sums->cycles >= 0.0f) && (sums->psi2 >= 0.0f) && (sums->square >= 0.0f) && ((t->parts != 0u) || !(sums->cycles > 0.0f));
    for (uint32_t k = 0; k < t->positions; ++k) { ok = ok && (sd_kalman_has_tooth(t, k) || (sums->late[k] == 0.0f)); }
    for (uint32_t i = 0; i < SD_KALMAN_HIDDEN_MAX; ++i) { ok = ok && sd_hidden_ok(&sums->hidden[i]); }
    return ok;
}

void sd_fired_resume(sd_fired_t *self, const sd_kalman_tables_t *t, const sd_fired_sums_t *sums) {
    forget(self);
    if ((t->parts == 0u) || (sums->cycles < (float)SD_FIRED_CYCLES_MIN)) { return; }
    for (uint32_t round = 0; round < 2u; ++round) { /* the second by the variance that the first one found */
        begin_placing(self, t, sums);
        for (uint32_t k = 0; k < t->positions; ++k) {
            if (sd_kalman_has_tooth(t, k)) { place_tooth(self, t, sums, k); }
        }
        conclude(self, t, sums);
    }
    self->work.phase = SD_FIRED_RESTS;
}
