/* SPDX-License-Identifier: MIT */
#include "sd_misfire.h"

#include <string.h>

#include "sd_math.h"

#define FACTOR_MIN 0.6f    /* the expectation may learn no further than this, or a misfire could become normal */
#define FACTOR_MAX 1.5f
#define SCATTER_START 1.0f
#define SCATTER_MIN 0.01f
#define SCATTER_MAX 1e6f
#define RHO_MAX        0.9f
#define OFF_MAX        0.5f /* of a firing, that tells of the next */
#define RHO_LEARN      128.0f
#define RHO_CHANCE     0.2f /* a correlation learned from so many firings may be that large by chance */
#define LEARN_FIRINGS  64u  /* factors are means of so many firings, fewer after init */
#define LEARN_SCATTER  128u /* the scatter too */
#define SCATTER_MARGIN 1.05f /* that its deviation, learned, may be short of the true one */
#define SCATTER_CHANCE 8.0f  /* over n, the square of two deviations by which a mean of n squares is off by chance */
#define LEARNED_ENOUGH 16u /* firings of a cylinder before its scatter says anything */

static float larger(float a, float b) { return (a > b) ? a : b; }
static float smaller(float a, float b) { return (a < b) ? a : b; }
static uint32_t count_up(uint32_t x) { return (x < UINT32_MAX) ? x + 1u : x; }

/* ---- what is not judged ------------------------------------------------------------------------------------------ */

static bool is_number(float x, float high) { return (x > -high) && (x < high); } /* false for NaN */

static bool estimate_fit(const sd_misfire_t *self, const sd_misfire_firing_t *f) {
    return (f->index < self->config.cylinders) && (f->health != (uint8_t)SD_INVALID) && is_number(f->torque_nm, 1e6f) &&
           (f->torque_sd_nm >= 0.0f) && is_number(f->torque_sd_nm, 1e6f) && (f->speed_radps > 0.0f) &&
           is_number(f->speed_radps, 1e4f);
}

static float expected_torque(const sd_misfire_t *self, const sd_misfire_firing_t *f) {
    return f->fuel_mg * self->config.work_per_fuel_jpmg / SD_PI * self->factor[f->index];
}

static bool fuelled(const sd_misfire_t *self, const sd_misfire_firing_t *f) {
    const float expected = expected_torque(self, f);
    return (f->fuel_mg >= self->config.fuel_min_mg) && is_number(f->fuel_mg, 1e6f) && (expected > 0.0f) &&
           (expected >= self->config.torque_min_nm);
}

static bool shifting(const sd_misfire_t *self, const sd_misfire_firing_t *f) {
    const float change = f->speed_radps - self->last_speed_radps;
    /* One firing more or less, of work W, changes the speed by W / 2 E of itself. */
    const float of_firing = (f->energy_j > 0.0f) ? 0.5f * SD_PI * expected_torque(self, f) / f->energy_j : 0.0f;
    const float limit = (self->config.speed_change + sd_clamp(of_firing, 0.0f, 1.0f)) * f->speed_radps;
    return (self->last_speed_radps > 0.0f) && ((change > limit) || (change < -limit));
}

static uint8_t inhibited(sd_misfire_t *self, const sd_misfire_firing_t *f) {
    uint32_t why = f->inhibit;
    if (!estimate_fit(self, f)) {
        why |= SD_INHIBIT_ESTIMATE;
    } else {
        if (!fuelled(self, f)) { why |= SD_INHIBIT_FUEL_CUT; }
        if ((f->geared == 0u) && shifting(self, f)) { why |= SD_INHIBIT_SHIFT; }
        self->last_speed_radps = f->speed_radps;
    }
    if ((why & ((uint32_t)SD_INHIBIT_FUEL_CUT | (uint32_t)SD_INHIBIT_SHIFT)) != 0u) {
        self->hold = self->config.hold_firings;
    } else if (self->hold > 0u) {
        self->hold--;
        why |= SD_INHIBIT_HOLD;
    }
    if (self->since_start < self->config.start_firings) {
        self->since_start++;
        why |= SD_INHIBIT_START;
    }
    return (uint8_t)why;
}

/* ---- the limit --------------------------------------------------------------------------------------------------- */

static float weight_of(uint32_t seen) { return 1.0f / (4.0f + (float)seen); }

typedef struct sd_spread { float healthy, missed; } sd_spread_t; /* sd_0, sd_1 */

static sd_spread_t spread_of(const sd_misfire_t *self, float relative_sd) {
    const float cyclic = self->config.cyclic * self->config.cyclic, noise = relative_sd * relative_sd;
    const float chance = sd_root(SCATTER_CHANCE * weight_of(self->scatter_seen));
    const float disturbed = larger(self->scatter - 1.0f - chance, 0.0f), r = smaller(self->scatter, 1.0f) + disturbed;
    return (sd_spread_t){ sd_root(r * cyclic + noise), sd_root(disturbed * cyclic + noise) };
}

static float limit_of(sd_misfire_t *self, sd_spread_t spread) {
    const float low = self->config.z_missed * spread.missed, wanted = self->config.z_false * spread.healthy;
    const float gap = SCATTER_MARGIN * wanted;
    self->test_ratio = low + wanted; /* the margin chooses the limit; it is no shortage */
    if (low + gap > 1.0f) { return low / (low + gap); }
    return sd_clamp(self->config.definition, low, 1.0f - gap);
}

static uint8_t verdict_of(const sd_misfire_t *self, float index, float limit, sd_spread_t spread) {
    if (index < limit) { return SD_MISFIRE; }
    const bool weak = (index < self->config.partial) && (index < 1.0f - self->config.z_false * spread.healthy);
    return weak ? SD_PARTIAL_BURN : SD_HEALTHY;
}

/* What the last firing tells of this one's error. */
static float carried(const sd_misfire_t *self) {
    const float square = self->off_square * self->off_square, product = self->off_product * self->off_product;
    if (!(product > RHO_CHANCE * RHO_CHANCE * square)) { return 0.0f; }
    const float sure = 1.0f - RHO_CHANCE * RHO_CHANCE * square / product;
    return sd_clamp(self->off_product / self->off_square * sure, -RHO_MAX, RHO_MAX) * self->last_off;
}

static void learn_carry(sd_misfire_t *self, const sd_misfire_verdict_t *v, float off) {
    const bool healthy = v->verdict == (uint8_t)SD_HEALTHY, misfire = v->verdict == (uint8_t)SD_MISFIRE;
    const float here = sd_clamp(misfire ? off + 1.0f : off, -OFF_MAX, OFF_MAX);
    if (healthy && (self->last_off != 0.0f)) {
        const float weight = 1.0f / RHO_LEARN;
        self->off_square += weight * (0.5f * (here * here + self->last_off * self->last_off) - self->off_square);
        self->off_product += weight * (here * self->last_off - self->off_product);
    }
    self->last_off = (healthy || misfire) ? here : 0.0f;
}

/* Scatter is seen above the expectation, where no misfire comes. */
static void learn_scatter(sd_misfire_t *self, const sd_misfire_verdict_t *v, float relative_sd, sd_spread_t spread) {
    const float off = v->index - 1.0f;
    self->innovation = off;
    if (!(off > 0.0f) || (self->learned[v->firing] < LEARNED_ENOUGH)) { return; }
    const float size = sd_clamp(off, 0.0f, 10.0f * spread.healthy), cyclic = self->config.cyclic;
    const float seen = (size * size - relative_sd * relative_sd) / (cyclic * cyclic);
    self->scatter = sd_clamp(self->scatter + weight_of(self->scatter_seen) * (seen - self->scatter), SCATTER_MIN, SCATTER_MAX);
    if (self->scatter_seen < LEARN_SCATTER) { self->scatter_seen++; }
}

/* Only a healthy firing near the expectation moves it (and any but a misfire while nothing is known of that cylinder).
 * What all firings are off by is the expectation's, so `off` has nothing carried over taken out. */
static void learn_factor(sd_misfire_t *self, const sd_misfire_verdict_t *v, float off, sd_spread_t spread) {
    const uint32_t firing = v->firing;
    const bool unknown = self->learned[firing] < LEARNED_ENOUGH;
    const float near = larger(0.25f, 2.0f * spread.healthy); /* an overlooked misfire is not */
    const bool teaches = (off > -near) && (off < near) && (v->verdict == (uint8_t)SD_HEALTHY);
    if (teaches || (unknown && (v->verdict != (uint8_t)SD_MISFIRE))) {
        const float factor = self->factor[firing] * (1.0f + weight_of(self->learned[firing]) * sd_clamp(off, -0.5f, 0.5f));
        if (self->learned[firing] < LEARN_FIRINGS) { self->learned[firing]++; }
        self->factor[firing] = sd_clamp(factor, FACTOR_MIN, FACTOR_MAX);
    }
}

/* ---- windows and the lamp ---------------------------------------------------------------------------------------- */

static uint32_t misfires_in(const sd_misfire_window_t *window) {
    uint32_t sum = 0;
    for (uint32_t i = 0; i < SD_MISFIRE_CYLINDERS_MAX; ++i) { sum += window->misfires[i]; }
    return sum;
}

static uint8_t suspects_of(const sd_misfire_window_t *window) {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < SD_MISFIRE_CYLINDERS_MAX; ++i) {
        if (10u * window->misfires[i] > misfires_in(window)) { bits |= 1u << i; }
    }
    return (uint8_t)bits;
}

static bool exceeds(const sd_misfire_window_t *window, float percent) {
    return 100.0f * (float)misfires_in(window) > percent * (float)window->firings;
}

static void light(sd_misfire_t *self, const sd_misfire_window_t *window, bool enough, uint8_t lamp) {
    const uint8_t wanted = enough ? lamp : (uint8_t)SD_LAMP_PENDING;
    self->suspects = suspects_of(window);
    if (wanted > self->lamp) { self->lamp = wanted; }
}

static uint16_t count_up_16(uint16_t x) { return (x < UINT16_MAX) ? (uint16_t)(x + 1u) : x; }

/* Counts the firing; true, and the window in *last, when it is complete. */
static bool fill(sd_misfire_window_t *running, sd_misfire_window_t *last, uint32_t full, uint32_t cylinder, bool misfire) {
    running->firings++;
    if (misfire) { running->misfires[cylinder - 1u]++; }
    if (running->firings < full) { return false; }
    *last = *running;
    memset(running, 0, sizeof *running);
    return true;
}

void sd_misfire_count(sd_misfire_t *self, const sd_misfire_verdict_t *v) {
    const sd_misfire_config_t *c = &self->config;
    if ((v->verdict == (uint8_t)SD_NOT_JUDGED) || (v->firing >= c->cylinders)) { return; }
    const bool misfire = v->verdict == (uint8_t)SD_MISFIRE;
    self->firings = count_up(self->firings);
    if (misfire) { self->misfires = count_up(self->misfires); }
    if (v->verdict == (uint8_t)SD_PARTIAL_BURN) { self->partial_burns = count_up(self->partial_burns); }
    self->in_row[v->firing] = misfire ? count_up_16(self->in_row[v->firing]) : 0u;
    if (fill(&self->running_200, &self->last_200, 100u * c->cylinders, v->cylinder, misfire) &&
        exceeds(&self->last_200, c->catalyst_percent)) {
        self->catalyst_exceeded = count_up_16(self->catalyst_exceeded);
        light(self, &self->last_200, self->catalyst_exceeded >= c->catalyst_exceedances, SD_LAMP_BLINKS);
    }
    if (fill(&self->running_1000, &self->last_1000, 500u * c->cylinders, v->cylinder, misfire)) {
        const bool first = self->first_1000_done == 0u;
        self->first_1000_done = 1;
        if (exceeds(&self->last_1000, c->emission_percent)) {
            self->emission_exceeded = count_up_16(self->emission_exceeded);
            light(self, &self->last_1000, first || (self->emission_exceeded >= c->emission_exceedances), SD_LAMP_ON);
        }
    }
}

/* ---- the interface ----------------------------------------------------------------------------------------------- */

static void report_health(sd_misfire_t *self, const sd_misfire_firing_t *f, const sd_misfire_verdict_t *v) {
    self->health = (f->health > (uint8_t)SD_DEGRADED) ? (uint8_t)SD_INVALID : f->health;
    self->why = 0;
    if (v->inhibit != 0u) {
        self->health = SD_INVALID;
        self->why = ((v->inhibit & (uint8_t)SD_INHIBIT_START) != 0u) ? (uint16_t)SD_WHY_CONVERGING : (uint16_t)SD_WHY_REJECTED;
    } else if (self->test_ratio > 1.0f) {
        self->health = SD_DEGRADED;
        self->why = SD_WHY_REJECTED;
    }
}

sd_misfire_verdict_t sd_misfire_assess(sd_misfire_t *self, const sd_misfire_firing_t *f) {
    sd_misfire_verdict_t v;
    memset(&v, 0, sizeof v);
    v.verdict = SD_NOT_JUDGED;
    v.inhibit = inhibited(self, f);
    if (f->index < self->config.cylinders) {
        v.firing = f->index;
        v.cylinder = self->config.firing_order[f->index];
    }
    if (v.inhibit == 0u) {
        const float expected = expected_torque(self, f);
        const float relative_sd = sd_clamp(f->torque_sd_nm / expected, 0.0f, 10.0f);
        const sd_spread_t spread = spread_of(self, relative_sd);
        const float found = sd_clamp(f->torque_nm / expected, -10.0f, 10.0f);
        v.index = sd_clamp(found - carried(self), -10.0f, 10.0f);
        v.index_sd = spread.healthy;
        v.limit = limit_of(self, spread);
        v.verdict = verdict_of(self, v.index, v.limit, spread);
        learn_scatter(self, &v, relative_sd, spread);
        learn_factor(self, &v, found - 1.0f, spread);
        learn_carry(self, &v, found - 1.0f);
    } else {
        self->rejected = count_up_16(self->rejected);
        self->last_off = 0.0f;
    }
    report_health(self, f, &v);
    return v;
}

sd_misfire_verdict_t sd_misfire_judge(sd_misfire_t *self, const sd_misfire_firing_t *f) {
    const sd_misfire_verdict_t v = sd_misfire_assess(self, f);
    sd_misfire_count(self, &v);
    return v;
}

void sd_misfire_start(sd_misfire_t *self) {
    self->since_start = 0;
    self->hold = 0;
    self->last_speed_radps = 0.0f;
    self->last_off = 0.0f;
    memset(self->in_row, 0, sizeof self->in_row);
    self->health = SD_INVALID;
    self->why = SD_WHY_CONVERGING;
}

static float percent(const sd_misfire_window_t *window, uint32_t i, uint32_t cylinders) {
    if (window->firings == 0u) { return 0.0f; }
    return 100.0f * (float)(window->misfires[i] * cylinders) / (float)window->firings;
}

sd_status_t sd_misfire_status(const sd_misfire_t *self) {
    return (sd_status_t){ .health = self->health, .why = self->why, .rejected = self->rejected, .innovation = self->innovation,
                          .test_ratio = self->test_ratio };
}

void sd_misfire_read(const sd_misfire_t *self, sd_misfire_report_t *report) {
    const sd_misfire_config_t *c = &self->config;
    memset(report, 0, sizeof *report);
    uint32_t continuous = 0;
    for (uint32_t i = 0; i < c->cylinders; ++i) {
        report->percent_200[i] = percent(&self->last_200, i, c->cylinders);
        report->percent_1000[i] = percent(&self->last_1000, i, c->cylinders);
        if (self->in_row[i] >= c->continuous_firings) { continuous |= 1u << (c->firing_order[i] - 1u); }
    }
    report->firings = self->firings;
    report->misfires = self->misfires;
    report->partial_burns = self->partial_burns;
    report->continuous = (uint8_t)continuous;
    report->suspects = self->suspects;
    report->lamp = self->lamp;
    report->emission_exceeded = self->emission_exceeded;
    report->catalyst_exceeded = self->catalyst_exceeded;
    report->status = sd_misfire_status(self);
}

/* Written so that NaN is out of range. */
static bool in(float x, float low, float high) { return (x >= low) && (x <= high); }

static bool order_ok(const sd_misfire_config_t *c) {
    uint32_t seen = 0;
    if ((c->cylinders < 1u) || (c->cylinders > SD_MISFIRE_CYLINDERS_MAX)) { return false; }
    for (uint32_t i = 0; i < c->cylinders; ++i) {
        if ((c->firing_order[i] < 1u) || (c->firing_order[i] > c->cylinders)) { return false; }
        seen |= 1u << (c->firing_order[i] - 1u);
    }
    return seen == (1u << c->cylinders) - 1u;
}

static bool config_ok(const sd_misfire_config_t *c) {
    return order_ok(c) && in(c->work_per_fuel_jpmg, 1e-3f, 100.0f) && in(c->cyclic, 1e-3f, 0.5f) &&
           in(c->z_false, 1.0f, 6.0f) && in(c->z_missed, 1.0f, 6.0f) && in(c->definition, 0.2f, 0.8f) &&
           in(c->partial, c->definition, 1.0f) && in(c->fuel_min_mg, 1e-3f, 1e4f) && in(c->torque_min_nm, 0.0f, 1e5f) &&
           in(c->speed_change, 1e-3f, 1.0f) && (c->continuous_firings >= 2u) && in(c->emission_percent, 1e-3f, 100.0f) &&
           in(c->catalyst_percent, 1e-3f, 100.0f) && (c->emission_exceedances >= 1u) && (c->catalyst_exceedances >= 1u);
}

static void forget(sd_misfire_t *self) {
    self->scatter = SCATTER_START;
    self->scatter_seen = 0;
    self->last_off = self->off_square = self->off_product = 0.0f;
    memset(self->learned, 0, sizeof self->learned);
    for (uint32_t i = 0; i < SD_MISFIRE_CYLINDERS_MAX; ++i) { self->factor[i] = 1.0f; }
    sd_misfire_start(self);
}

sd_result_t sd_misfire_init(sd_misfire_t *self, const sd_misfire_config_t *c) {
    if (!config_ok(c)) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->config = *c;
    forget(self);
    return SD_OK;
}

sd_result_t sd_misfire_configure(sd_misfire_t *self, const sd_misfire_config_t *c) {
    const sd_misfire_config_t before = self->config;
    bool ok = config_ok(c) && (c->cylinders == before.cylinders);
    for (uint32_t i = 0; ok && (i < c->cylinders); ++i) { ok = c->firing_order[i] == before.firing_order[i]; }
    if (!ok) { return SD_ERR_CONFIG; }
    self->config = *c;
    if ((c->work_per_fuel_jpmg != before.work_per_fuel_jpmg) || (c->cyclic != before.cyclic)) { forget(self); }
    return SD_OK;
}
