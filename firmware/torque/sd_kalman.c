/* SPDX-License-Identifier: MIT */
#include "sd_kalman.h"

#include <string.h>

#include "sd_kalman_firing.h"
#include "sd_motion_inline.h"

#define TWIST_MAX_RAD 2.0f    /* no flywheel's spring goes so far */
#define WEIGHT        16384.0f /* of two speeds together; gain_scale is over it */
#define MARK_SQUARE   4.5f     /* half the square of a mark, which is three pitches long */
#define JITTER_SQUARE 64.0f   /* a settled filter takes teeth up to 8 times the innovation as met */

#if SD_CYLINDERS_MAX == 8
_Static_assert(sizeof(sd_kalman_t) == 1244, "without pointers, the same size on every target");
#endif

enum { REJECTED_IN_ROW_MAX = 12 }; /* teeth left out in a row after which the estimate itself must be wrong */

/* ---- correction ------------------------------------------------------------------------------------------------ */

/* Lateness that a torque explains, rad: over a mark, at an energy scale J w^2. Once settled it is known: a firing comes or fails, and
 * its peak is some 4 times its mean. */
static float explained_by_torque(const sd_kalman_filter_t *f, const sd_kalman_tables_t *t, const sd_kalman_choice_t *choice, bool settled,
                                 float scale) {
    const float least = 0.05f * choice->torque_base_nm, met = 6.0f * f->peak_nm;
    const float torque = !settled ? choice->torque_base_nm : (met > least) ? met : least;
    return MARK_SQUARE * t->pitch_rad * t->pitch_rad * torque / scale;
}

/* How late a tooth may be: jitter, once settled by the innovation as met, and what a torque that nobody expects does over a mark,
 * which is asked only where jitter is not enough. Without a root: the part that a torque does not explain is squared. */
static inline bool plausible(sd_kalman_filter_t *f, const sd_kalman_tables_t *t, const sd_kalman_choice_t *choice, bool settled,
                             float expected, float scale) {
    const float size = __builtin_fabsf(f->innovation_rad), reject = choice->reject_rad;
    const float jitter = settled ? JITTER_SQUARE * expected * expected * f->noise_ratio : reject * reject;
    f->jitter_square = jitter;
    if (size * size <= jitter) { f->rejected_in_row = 0; return true; }
    const float beyond = size - explained_by_torque(f, t, choice, settled, scale);
    if (!(beyond > 0.0f) || (beyond * beyond <= jitter)) { f->rejected_in_row = 0; return true; }
    if (f->rejected < UINT16_MAX) { f->rejected++; }
    f->rejected_in_row++;
    return false;
}

/* The gain is that of shape times the mean torque. */
static void bend_pulses(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_filter_t *f, float change_nm) {
    const float firings = (float)t->firings, sum = sd_kalman_sum_firings(f, t);
    if (!(sum > firings * t->shape_min_nm)) { return; }
    const float shape = self->shape + firings * change_nm / sum;
    self->shape = (shape < SD_KALMAN_SHAPE_MIN) ? SD_KALMAN_SHAPE_MIN : (shape > SD_KALMAN_SHAPE_MAX) ? SD_KALMAN_SHAPE_MAX : shape;
}

/* Gains of a row between two speeds. */
typedef struct sd_mix {
    const int16_t *gain; /* column 0, the lower of the speeds */
    uint32_t speeds;     /* from one column to the next */
    sd_pair_t weight;    /* of both, together WEIGHT */
} sd_mix_t;

static inline float mix(const sd_mix_t *m, uint32_t j) {
    sd_pair_t pair;
    memcpy(&pair, m->gain + j * m->speeds, sizeof pair);
    return (float)sd_dot_pair(pair, m->weight);
}

static void correct_modes(sd_motion_t *motion, const sd_kalman_tables_t *t, const sd_mix_t *m, uint32_t j, const float *scale, float r) {
    for (uint32_t i = 0; i < t->modes; ++i, j += 2u) {
        motion->twist_rad[i] += mix(m, j) * (scale[2u * i] * r);
        motion->swing_rad[i] += mix(m, j + 1u) * (scale[2u * i + 1u] * r);
    }
}

/* Where a tooth or three more make no difference. */
static bool every_fourth(const sd_kalman_filter_t *f) { return (f->teeth & 3u) == 0u; }

static float peak_of(const float *x, uint32_t count) {
    float peak = 0.0f;
    for (uint32_t j = 0; j < count; ++j) { peak = (__builtin_fabsf(x[j]) > peak) ? __builtin_fabsf(x[j]) : peak; }
    return peak;
}

/* Adds the gains times the innovation r; push is r s. */
static void take_in(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, const sd_mix_t *m, bool settled, float speed,
                    float push) {
    sd_kalman_filter_t *f = &self->filter[which];
    const float *scale = t->gain_scale[which];
    const float r = f->innovation_rad, pull = scale[3] * push;
    float *x = f->motion.coefficient_nm;
    f->motion.lateness_s += mix(m, 0) * (scale[0] * r / speed);
    f->motion.energy_j += mix(m, 1) * (scale[1] * push);
    x[0] += mix(m, 2) * (scale[2] * push);
    const uint32_t count = t->coefficients;
    _Pragma("GCC unroll 4")
    for (uint32_t j = 1; j < count; ++j) { x[j] += mix(m, j + 2u) * pull; }
    if (every_fourth(f)) { f->peak_nm = peak_of(x, count); }
    if (settled && (t->shapes != 0u) && (which == self->believed)) {
        bend_pulses(self, t, f, mix(m, count + 2u) * (scale[4] * push));
    }
    if (t->modes != 0u) { correct_modes(&f->motion, t, m, count + 2u + t->shapes, &scale[5], r); }
}

/* What all filters take at a tooth. */
typedef struct sd_at_tooth {
    const sd_kalman_tooth_t *tooth;
    sd_motion_row_t row; /* of the interval before it */
    float period_s, shape;
} sd_at_tooth_t;

enum { SETTLING = 1, SETTLED = 2 };

/* Without modes the normalised map is the same at every speed, so every table is stable at any. That of half the speed trusts the state
 * less, which is right while there is little to trust. */
static void find_place(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, bool settled, float speed,
                       sd_kalman_filter_t *f) {
    const float seen = speed * self->tuning.gain_speed;
    const sd_between_t at = sd_kalman_between(t, 0, (settled || (t->modes > 0u)) ? seen : 0.5f * seen);
    const float *expects = &t->expected_rad[which * t->speeds];
    const int32_t high = (int32_t)(at.share * WEIGHT);
    sd_kalman_place_t *place = &f->place;
    place->at = (uint8_t)at.at;
    place->weight.half[0] = (int16_t)((int32_t)WEIGHT - high);
    place->weight.half[1] = (int16_t)high;
    place->expected_rad = expects[at.at] + at.share * (expects[at.next] - expects[at.at]);
    place->per_expected = 1.0f / place->expected_rad;
    place->of = settled ? (uint8_t)SETTLED : (uint8_t)SETTLING;
}

static void correct(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, const sd_at_tooth_t *at) {
    sd_kalman_filter_t *f = &self->filter[which];
    const sd_kalman_word_t *word = at->row.word;
    const float square = f->motion.energy_j * word[SD_ROW_TOOTH].value, speed = sd_sqrt_f32(square);
    const float scale = t->inertia_mean_kgm2 * square;
    f->innovation_rad = sd_motion_late(&f->motion, t, speed, &self->tuning) - at->tooth->late_rad;
    const bool settled = f->teeth >= self->choice.settle_teeth;
    const bool due = ((f->teeth + 2u * which + 1u) & 3u) == 0u; /* each filter at a tooth that has nothing else of the kind to do */
    if (due || (f->place.of != (settled ? (uint8_t)SETTLED : (uint8_t)SETTLING))) {
        find_place(self, t, which, settled, speed, f);
    }
    if (!plausible(f, t, &self->choice, settled, f->place.expected_rad, scale)) { return; }
    if (settled) { /* running mean square over some 2 cycles of what the tables expect to be 1 */
        const float ratio = f->innovation_rad * f->place.per_expected;
        f->noise_ratio += (ratio * ratio - f->noise_ratio) * (1.0f / 256.0f);
    }
    const sd_mix_t m = { word[t->gains_at].gain + which * t->speeds * sd_motion_columns(t) + f->place.at, t->speeds, f->place.weight };
    take_in(self, t, which, &m, settled, speed, f->innovation_rad * scale);
}

/* ---- a tooth --------------------------------------------------------------------------------------------------- */

static void restart(sd_kalman_filter_t *f) {
    const uint16_t rejected = f->rejected;
    memset(f, 0, sizeof *f);
    f->noise_ratio = 1.0f;
    f->rejected = rejected;
}

/* Energy half a pitch before the tooth, from the tooth period. */
static void begin(sd_kalman_filter_t *f, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth) {
    const float speed = t->pitch_rad * t->tick_hz / (float)tooth->period_ticks;
    const float energy = speed * speed / sd_motion_word(t, tooth->cycle_position)[SD_ROW_INTERVAL].value;
    restart(f);
    if (!(energy > sd_motion_energy_min(t))) { return; }
    f->motion.energy_j = energy;
    f->running = 1;
}

/* A number that is none comes with an energy that is none, because both take the same innovation. */
static bool in_range(const sd_kalman_filter_t *f, const sd_kalman_tables_t *t, float torque_base_nm) {
    for (uint32_t m = 0; m < t->modes; ++m) {
        const float q = f->motion.twist_rad[m], v = f->motion.swing_rad[m];
        if (!((q > -TWIST_MAX_RAD) && (q < TWIST_MAX_RAD) && (v > -TWIST_MAX_RAD) && (v < TWIST_MAX_RAD))) { return false; }
    }
    if (!(f->motion.energy_j > sd_motion_energy_min(t)) || (f->rejected_in_row > REJECTED_IN_ROW_MAX)) { return false; }
    return !every_fourth(f) || ((f->peak_nm < torque_base_nm) && (f->motion.energy_j < 1e9f) &&
        (__builtin_fabsf(f->motion.lateness_s) < 1.0f));
}

/* Reads the firing that is due at a row, unless the filter began within its pulse. Returns true when it did. */
static bool read_due(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, const sd_kalman_word_t *word,
                     const sd_kalman_tooth_t *tooth, sd_firing_t *firing) {
    const uint32_t read = word[SD_ROW_AT].at.read;
    if ((read == 0u) || (self->filter[which].teeth < t->positions)) { return false; }
    sd_kalman_read_firing(self, t, which, read - 1u, tooth, &firing[which]);
    return true;
}

/* The pulses as the calibration has them: with a shape that is still being learned, what is learned from it would move too. */
static inline void move_free(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row) {
    if (!sd_motion_move(&self->free, t, row, 0.0f, &self->tuning)) { self->free_runs = 0; }
}

/* Every running filter over one interval at whose end no tooth came: those that stand still in it stop. Returns those that completed
 * a firing. */
static uint32_t coast(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t k, const sd_kalman_tooth_t *tooth, sd_firing_t *firing) {
    sd_motion_row_t row;
    uint32_t complete = 0;
    (void)sd_motion_sum_known(t, k, &self->charge, &row);
    sd_motion_close_valves(&self->charge, t, row.word);
    if (self->free_runs != 0u) { move_free(self, t, &row); }
    for (uint32_t i = 0; i < self->filters; ++i) {
        sd_kalman_filter_t *f = &self->filter[i];
        if (f->running == 0u) { continue; }
        if (!sd_motion_predict(&f->motion, t, &row, self->shape, &self->tuning)) {
            restart(f);
        } else if (read_due(self, t, i, row.word, tooth, firing)) {
            complete |= 1u << i;
        }
    }
    return complete;
}

/* One filter over the last interval and its correction by the tooth, in one pass. Returns bit `which` when it completed a firing. */
static inline uint32_t take_tooth(sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, const sd_at_tooth_t *at,
                                  sd_firing_t *firing) {
    sd_kalman_filter_t *f = &self->filter[which];
    bool good = sd_motion_move(&f->motion, t, &at->row, at->shape, &self->tuning);
    uint32_t complete = 0;
    if (good && read_due(self, t, which, at->row.word, at->tooth, firing)) { complete = 1u << which; }
    f->motion.lateness_s -= at->period_s;
    if (good && (at->tooth->trusted != 0u)) { correct(self, t, which, at); }
    good = good && in_range(f, t, self->choice.torque_base_nm);
    if (!good) { restart(f); return 0u; }
    if (f->teeth < UINT16_MAX) { f->teeth++; }
    return complete;
}

/* Positions between two placed teeth. */
static uint32_t coast_to(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth, sd_firing_t *firing) {
    const uint32_t cycle = 2u * t->positions;
    uint32_t complete = 0, k = tooth->cycle_position + cycle - tooth->advance;
    if (k >= cycle) { k -= cycle; }
    for (uint32_t left = tooth->advance; left > 1u; --left) {
        k = (k + 1u < cycle) ? k + 1u : 0u;
        complete |= coast(self, t, k, tooth, firing);
    }
    return complete;
}

uint32_t sd_kalman_step(sd_kalman_t *self, const sd_kalman_tables_t *t, const sd_kalman_tooth_t *tooth, sd_firing_t *firing) {
    const uint32_t cycle = 2u * t->positions;
    if ((tooth->cycle_position >= cycle) || (tooth->advance < 1u) || (tooth->advance > cycle)) { return 0u; }
    sd_motion_take_intake(&self->charge, tooth->intake_bar);
    const bool begins = (tooth->advance == 1u) && (tooth->trusted != 0u) && (tooth->period_ticks > 0u);
    const bool none_runs = (self->filter[0].running | self->filter[SD_KALMAN_SETS_MAX - 1].running) == 0u;
    uint32_t complete = 0;
    if (none_runs) { sd_motion_fill(&self->charge, self->charge.intake_bar); }
    if (tooth->advance > 1u) { complete = coast_to(self, t, tooth, firing); }
    sd_at_tooth_t at; /* field by field: to zero it would cost a call */
    at.tooth = tooth;
    at.period_s = (float)tooth->period_ticks * self->tick_s;
    at.shape = self->shape;
    self->known_nm = sd_motion_sum_known(t, tooth->cycle_position, &self->charge, &at.row);
    if ((at.row.word[SD_ROW_AT].at.close != 0u) && !none_runs) { sd_motion_close_valves(&self->charge, t, at.row.word); }
    if (self->free_runs != 0u) {
        move_free(self, t, &at.row);
        self->free.lateness_s -= at.period_s;
    }
    for (uint32_t i = 0; i < self->filters; ++i) {
        sd_kalman_filter_t *f = &self->filter[i];
        if (f->running != 0u) {
            complete |= take_tooth(self, t, i, &at, firing);
        } else if (begins) {
            begin(f, t, tooth);
        }
        if (f->running == 0u) { complete &= ~(1u << i); }
    }
    return complete;
}

void sd_kalman_set_free(sd_kalman_t *self) {
    self->free = self->filter[self->believed].motion;
    self->free.lateness_s = 0.0f;
    self->free_runs = 1;
}

void sd_kalman_restart(sd_kalman_t *self) {
    self->free_runs = 0;
    for (uint32_t i = 0; i < SD_KALMAN_SETS_MAX; ++i) { restart(&self->filter[i]); }
    sd_motion_fill(&self->charge, self->charge.intake_bar);
}

float sd_kalman_torque(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which, uint32_t k) {
    return sd_motion_torque(&self->filter[which].motion, t, k, self->known_nm, self->shape, &self->tuning);
}

/* ---- status ---------------------------------------------------------------------------------------------------- */

sd_status_t sd_kalman_status(const sd_kalman_t *self, const sd_kalman_tables_t *t, uint32_t which) {
    const sd_kalman_filter_t *f = &self->filter[which];
    sd_status_t status = { .health = sd_kalman_health(self, which), .rejected = f->rejected, .innovation = f->innovation_rad };
    status.why = (uint16_t)sd_kalman_why(self, which);
    if (f->running == 0u) { return status; }
    const bool settled = f->teeth >= self->choice.settle_teeth;
    const float limit = explained_by_torque(f, t, &self->choice, settled, 2.0f * f->motion.energy_j) + sd_root(f->jitter_square);
    status.test_ratio = __builtin_fabsf(f->innovation_rad) / limit;
    return status;
}

sd_result_t sd_kalman_init(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_choice_t *choice, uint8_t filters) {
    if (!sd_kalman_tables_ok(tables) || !sd_kalman_choice_ok(choice) || (filters < 1u) ||
        (filters > tables->sets)) { return SD_ERR_CONFIG; }
    const sd_kalman_choice_t chosen = *choice; /* it may stand in *self */
    memset(self, 0, sizeof *self);
    self->choice = chosen;
    self->filters = filters;
    self->tick_s = 1.0f / tables->tick_hz;
    self->tuning = (sd_motion_tuning_t){ 1.0f, 1.0f, 1.0f };
    self->charge.intake_bar = 1.0f;
    sd_kalman_restart(self);
    return SD_OK;
}
