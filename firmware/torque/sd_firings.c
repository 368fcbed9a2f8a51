/* SPDX-License-Identifier: MIT */
#include "sd_firings.h"

#include <string.h>

#define ZERO_REVOLUTIONS 40u /* without fuel before a cylinder's zero is read: burnt gas is gone, the pattern known, the filter at rest */

#define SMOOTH 0u
#define ROUGH  1u

static const sd_kalman_filter_t *believed(const sd_firings_t *self) { return &self->kalman.filter[self->kalman.believed]; }

/* ---- the pattern that is believed --------------------------------------------------------------------------------- */

#define WORTH 0.25f /* of what a wheel has that is not known, or what was found: where firing leaves less of the pattern, it is believed, */
#define BETTER 0.5f /* or of what fuel cut leaves, which has fewer doubts that it does not state */

enum { BY_NONE, BY_CUT, BY_FIRING }; /* sd_firings_t.corrects */

/* To be asked where a pattern or what it is held against has changed. */
static uint8_t known_best(const sd_firings_t *self) {
    const sd_pattern_t *cut = &self->pattern;
    const sd_fired_pattern_t *fired = sd_fired_used(&self->fired);
    const bool by_cut = (cut->sd_rad > 0.0f) && (cut->sd_rad < self->unlearned_rad);
    const float wheel = (fired->found_rad > self->unlearned_rad) ? fired->found_rad : self->unlearned_rad;
    const float least = by_cut ? BETTER * cut->sd_rad : WORTH * wheel;
    if ((fired->sd_rad > 0.0f) && (fired->sd_rad < least)) { return (uint8_t)BY_FIRING; }
    return by_cut ? (uint8_t)BY_CUT : (uint8_t)BY_NONE;
}

static inline sd_firings_pattern_t pattern_of(const sd_firings_t *self) {
    const sd_pattern_t *cut = &self->pattern;
    const sd_fired_pattern_t *fired = sd_fired_used(&self->fired);
    if (self->corrects == (uint8_t)BY_FIRING) {
        return (sd_firings_pattern_t){ fired->late_rad, fired->cycles, fired->sd_rad, fired->tooth_rad, fired->hidden_share };
    }
    if (self->corrects == (uint8_t)BY_CUT) {
        return (sd_firings_pattern_t){ cut->late_rad, cut->sums.cycles, cut->sd_rad, cut->sd_rad, 0.0f };
    }
    return (sd_firings_pattern_t){ NULL, cut->sums.cycles, cut->sd_rad, self->unlearned_rad, 0.0f };
}

sd_firings_pattern_t sd_firings_believed(const sd_firings_t *self) { return pattern_of(self); }

/* ---- configuration --------------------------------------------------------------------------------------------- */

static bool config_ok(const sd_firings_config_t *config, const sd_kalman_choice_t *choice) {
    return sd_kalman_choice_ok(choice) && (config->settle_cycles >= 0.0f) && (config->settle_cycles <= 200.0f) &&
           (config->pattern_deg >= 0.0f) && (config->pattern_deg <= 10.0f) && (config->teeth >= 1u) &&
           (config->teeth <= SD_KALMAN_POSITIONS_MAX);
}

/* settle_cycles is out of range where the sum does not fit, and refused by config_ok. */
static sd_kalman_choice_t choice_of(const sd_firings_config_t *config) {
    const float teeth = config->settle_cycles * 2.0f * (float)config->teeth + 0.5f;
    return (sd_kalman_choice_t){ .torque_base_nm = config->torque_base_nm,
                                 .reject_rad = config->reject_deg * SD_RAD_PER_DEG,
                                 .settle_teeth = ((teeth >= 0.0f) && (teeth < 65535.0f)) ? (uint16_t)teeth : 0u };
}

static void take_config(sd_firings_t *self, const sd_firings_config_t *config, const sd_kalman_choice_t *choice) {
    self->kalman.choice = *choice;
    self->unlearned_rad = config->pattern_deg * SD_RAD_PER_DEG;
    self->fired.unlearned_rad = self->unlearned_rad;
    self->corrects = known_best(self);
    self->enabled = (config->enabled != 0u) ? 1u : 0u;
}

sd_result_t sd_firings_init(sd_firings_t *self, const sd_firings_config_t *config, const sd_kalman_tables_t *tables) {
    const sd_kalman_choice_t choice = choice_of(config);
    const bool present = tables->positions != 0u;
    if (present && (!config_ok(config, &choice) || !sd_kalman_tables_ok(tables))) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    if (!present) { return SD_OK; }
    (void)sd_kalman_init(&self->kalman, tables, &choice, tables->sets);
    sd_pattern_init(&self->pattern, tables);
    sd_fired_init(&self->fired);
    take_config(self, config, &choice);
    return SD_OK;
}

sd_result_t sd_firings_configure(sd_firings_t *self, const sd_firings_config_t *config, const sd_kalman_tables_t *tables) {
    const sd_kalman_choice_t choice = choice_of(config);
    if (tables->positions == 0u) { return SD_OK; }
    if (!config_ok(config, &choice)) { return SD_ERR_CONFIG; }
    const bool begins = (self->enabled == 0u) && (config->enabled != 0u);
    take_config(self, config, &choice);
    if (begins) { sd_firings_restart(self); }
    return SD_OK;
}

/* ---- learning in fuel cut -------------------------------------------------------------------------------------- */

static void take_zeros(sd_firings_t *self, const sd_kalman_tables_t *tables) {
    sd_pattern_zeros(&self->pattern, tables, self->kalman.zero_nm_per_bar);
}

/* Motored for so long that no cylinder of the cycle to come holds burnt gas. */
static bool is_motored(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth) {
    const uint32_t since = (uint32_t)self->motored + tooth->advance;
    self->motored = (uint16_t)((tooth->fuel_cut == 0u) ? 0u : (since > UINT16_MAX) ? UINT16_MAX : since);
    return self->motored > 4u * tables->positions;
}

/* What the filters run with besides the pattern. */
static void take_learned(sd_firings_t *self, const sd_kalman_tables_t *tables) {
    self->kalman.tuning = sd_twist_tuning(&self->pattern.sums.twist);
    sd_motion_set_exponent(&self->kalman.charge, tables, self->pattern.exponent);
    self->corrects = known_best(self);
}

/* While fuel burns, on a road that lets the load alone. */
static void learn_fired(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth, bool well) {
    if (well && (tooth->health == (uint8_t)SD_VALID) && (tooth->fuel_cut == 0u) && (self->on_rough == 0u)) {
        sd_fired_step(&self->fired, tables, &self->kalman, tooth->cycle_position, tooth->fuel_mg, self->corrects != (uint8_t)BY_NONE);
    } else {
        sd_fired_rest(&self->fired, &self->kalman);
    }
}

/* Returns whether the pattern changed. */
static bool learn(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth, const sd_kalman_tooth_t *seen,
                  bool well) {
    const bool known = (tooth->phase_known != 0u) && (tooth->intake_known != 0u);
    const bool motored = is_motored(self, tables, tooth) && known;
    const bool changed = motored ? sd_pattern_step(&self->pattern, tables, seen) : sd_pattern_rest(&self->pattern, tables);
    if (changed) { take_learned(self, tables); }
    learn_fired(self, tables, tooth, well);
    return changed;
}

/* What cylinders read without fuel is their zero. */
static void learn_zero(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth, const sd_firing_t *firing) {
    const bool rests = (self->motored > ZERO_REVOLUTIONS * tables->positions) && sd_twist_known(&self->pattern.twist, tables);
    if (!rests) { return; }
    if (sd_pattern_take_zero(&self->pattern, tables, firing, self->kalman.charge.charge_bar[firing->index], tooth->speed_radps)) {
        take_zeros(self, tables);
    }
}

/* ---- a tooth --------------------------------------------------------------------------------------------------- */

static sd_kalman_tooth_t filter_tooth(const sd_firings_t *self, const sd_firings_tooth_t *tooth) {
    const sd_firings_pattern_t pattern = pattern_of(self);
    return (sd_kalman_tooth_t){ .cycle_position = tooth->cycle_position,
                                .advance = tooth->advance,
                                .period_ticks = tooth->period_ticks,
                                .trusted = (tooth->health == (uint8_t)SD_VALID) ? 1u : 0u,
                                .late_rad = sd_firings_late(&pattern, tooth->position),
                                .pattern_rad = pattern.tooth_rad,
                                .hidden_share = pattern.hidden_share,
                                .intake_bar = tooth->intake_bar };
}

/* The road chooses between the filters, unless one of them had to begin anew. `complete`: bit i, filter i read a firing. */
static void choose(sd_firings_t *self, const sd_kalman_tables_t *tables, uint32_t complete, const sd_firing_t *firing, bool moves) {
    if (tables->sets < 2u) { return; }
    const uint8_t smooth = sd_kalman_health(&self->kalman, SMOOTH), rough = sd_kalman_health(&self->kalman, ROUGH);
    if ((smooth | rough) != (uint8_t)SD_VALID) {
        sd_road_restart(&self->road);
    } else if (complete == ((1u << SMOOTH) | (1u << ROUGH))) {
        (void)sd_road_step(&self->road, &firing[SMOOTH], &firing[ROUGH]);
    }
    self->on_rough = (uint8_t)((smooth != rough) ? (smooth > rough) : ((self->road.rough != 0u) || moves));
    self->kalman.believed = self->on_rough; /* the pulses' shape is learned by the one that is believed */
}

/* A tooth left out, or not sure, spoils the firings under way. */
static void watch_teeth(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth) {
    const bool bad = (tooth->health != (uint8_t)SD_VALID) || (believed(self)->rejected_in_row != 0u);
    self->doubt = (self->doubt > tooth->advance) ? (uint16_t)(self->doubt - tooth->advance) : 0u;
    if (bad && (self->doubt < tables->positions)) { self->doubt = tables->positions; }
}

void sd_firings_spurious(sd_firings_t *self, const sd_kalman_tables_t *tables) { self->doubt = (uint16_t)(4u * tables->positions); }

/* Returns whether filter and inputs are well, whatever the last teeth were. */
static bool judge(const sd_firings_t *self, const sd_firings_tooth_t *tooth, sd_status_t *status) {
    const sd_kalman_filter_t *filter = believed(self);
    uint32_t why = sd_kalman_why(&self->kalman, self->kalman.believed);
    if (tooth->intake_known == 0u) { why |= (uint32_t)SD_WHY_NO_INPUT; }
    if (tooth->phase_known == 0u) { why |= (uint32_t)SD_WHY_NO_PHASE; }
    const bool well = why == 0u, invalid = (filter->running == 0u) || (tooth->phase_known == 0u);
    if (self->doubt > 0u) { why |= (uint32_t)SD_WHY_FAULT; }
    status->why = (uint16_t)why;
    status->rejected = filter->rejected;
    status->health = invalid ? (uint8_t)SD_INVALID : (why != 0u) ? (uint8_t)SD_DEGRADED : (uint8_t)SD_VALID;
    status->innovation = filter->innovation_rad;
    status->test_ratio = 0.0f;
    return well;
}

void sd_firings_restart(sd_firings_t *self) {
    if (self->enabled == 0u) { return; }
    sd_kalman_restart(&self->kalman);
    sd_road_restart(&self->road);
    sd_pattern_pause(&self->pattern);
    self->motored = 0;
}

void sd_firings_step(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth, sd_firings_out_t *out) {
    if (self->enabled == 0u) {
        memset(out, 0, sizeof *out);
        out->status = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_UNCALIBRATED };
        return;
    }
    const sd_kalman_tooth_t seen = filter_tooth(self, tooth);
    sd_firing_t firing[SD_KALMAN_SETS_MAX];
    const uint32_t complete = sd_kalman_step(&self->kalman, tables, &seen, firing);
    choose(self, tables, complete, firing, tooth->driveline == (uint8_t)SD_DRIVELINE_MOVES);
    watch_teeth(self, tables, tooth);
    const sd_kalman_filter_t *filter = believed(self);
    out->rough = self->on_rough;
    out->restarted = ((self->kalman.filter[SMOOTH].teeth == 0u) || (filter->teeth == 0u)) ? 1u : 0u;
    const bool well = judge(self, tooth, &out->status);
    const bool runs = (filter->running != 0u) && (tooth->cycle_position < 2u * tables->positions);
    out->waveform_nm = runs ? sd_kalman_torque(&self->kalman, tables, self->kalman.believed, tooth->cycle_position) : 0.0f;
    out->level_nm = runs ? filter->motion.coefficient_nm[0] : 0.0f;
    out->energy_j = filter->motion.energy_j;
    out->learned = learn(self, tables, tooth, &seen, well) ? 1u : 0u;
    out->complete = (uint8_t)((complete >> self->kalman.believed) & 1u);
    if (out->complete == 0u) { return; }
    out->firing = firing[self->kalman.believed];
    out->speed_radps = sd_root(2.0f * filter->motion.energy_j / tables->inertia_mean_kgm2);
    if (out->status.health == (uint8_t)SD_VALID) { learn_zero(self, tables, tooth, &out->firing); }
}

/* ---- the 10 ms task ------------------------------------------------------------------------------------------------ */

void sd_firings_task_begin(sd_firings_t *self) { sd_fired_hand_over(&self->fired); }

void sd_firings_task_work(sd_firings_t *self, const sd_kalman_tables_t *tables) {
    sd_fired_work(&self->fired, tables, &self->pattern.sums.fired);
}

bool sd_firings_task_end(sd_firings_t *self) {
    if (!sd_fired_take_over(&self->fired)) { return false; }
    self->corrects = known_best(self);
    return true;
}

/* ---- what is kept -------------------------------------------------------------------------------------------------- */

void sd_firings_keep(const sd_firings_t *self, const sd_kalman_tables_t *tables, sd_pattern_sums_t *learned) {
    sd_pattern_keep(&self->pattern, tables, learned);
}

sd_result_t sd_firings_resume(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_pattern_sums_t *learned) {
    if ((self->enabled == 0u) || (sd_pattern_resume(&self->pattern, tables, learned) != SD_OK)) { return SD_ERR_CONFIG; }
    sd_fired_resume(&self->fired, tables, &self->pattern.sums.fired);
    take_zeros(self, tables);
    take_learned(self, tables);
    return SD_OK;
}
