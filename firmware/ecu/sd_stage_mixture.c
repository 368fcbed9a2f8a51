/* SPDX-License-Identifier: MIT */
#include "sd_stage_mixture.h"

#include <string.h>

#include "sd_math.h"

enum { PROBE_AFTER = 40, /* cycles of learning trims: what is far off has shown by then without a probe */
       EGR_AFTER = 8 };  /* cycles, until the mean lambda is worth anything */

#define KNOWN_RAD     0.175f /* crank: a delay known to this needs no probe */
#define MENDED_RAD    0.5f   /* crank: a delay found to be off by more makes the trims' loop another one */
#define FOLLOW_LEAST  0.001f
#define EGR_OPEN      0.02f  /* the valve, by its position, is open: below, its sensor may be off by so much */
#define EGR_PACE      0.1f   /* a cycle */
#define LEAST_BURNED  0.05f
#define CHAIN_FOLLOWS 0.3f   /* a cycle: it settles to a tenth in some 4 */

static bool ready(const sd_stage_mixture_t *self) { return self->afr.config.cylinders != 0u; }

/* The filter is told of the trims. The chain is not: its inverted sensor finds a trim some cycles later, and until then its
 * observer would take back what it was told. */
static bool is_told(const sd_stage_mixture_t *self) { return self->afr.config.method == (uint8_t)SD_AFR_JOINT; }

static sd_afr_tables_t tables_of(const sd_calibration_t *page) {
    return (sd_afr_tables_t){ .grid = &page->afr, .sine_q31 = page->fourier.sine_q31 };
}

/* ---- init ------------------------------------------------------------------------------------------------------ */

static sd_result_t init_afr(sd_afr_t *afr, const sd_calibration_t *page, const sd_parameters_t *p) {
    sd_afr_config_t config = { .method = (uint8_t)(p->afr_method + 0.5f), .cycle_positions = (uint16_t)(2u * page->positions),
                               .cylinders = page->cylinders, .noise_per_rthz = p->afr_sensor_noise, .drift = p->afr_cylinder_drift,
                               .drift_slow = p->afr_cylinder_drift_slow, .jump = p->afr_cylinder_jump, .slow_above = p->afr_slow_mode_above,
                               .gain_air = p->afr_gain_air, .gain_cylinder = p->afr_gain_cylinder,
                               .inversion_gain = p->afr_inversion_gain, .inversion_floor = p->afr_inversion_floor,
                               .gain_mass = p->afr_gain_mass, .turbine_drop = p->afr_turbine_drop,
                               .turbine_rpm = p->afr_turbine_rated_rpm };
    /* The joint filter has one arithmetic. */
    config.fixed_point = ((p->afr_arithmetic > 0.5f) && (config.method != (uint8_t)SD_AFR_JOINT)) ? 1u : 0u;
    for (uint32_t i = 0; i < page->cylinders; ++i) { config.firing_position[i] = page->firing_position[i]; }
    const sd_afr_tables_t tables = tables_of(page);
    return sd_afr_init(afr, &config, &tables);
}

static sd_result_t init_delay(sd_afr_delay_t *delay, const sd_calibration_t *page) {
    const sd_afr_delay_config_t config = { .cycle_positions = (uint16_t)(2u * page->positions), .cylinders = page->cylinders,
                                           .tau1_s = page->afr.tau1_s, .tau2_s = page->afr.tau2_s };
    return (page->cylinders < 2u) ? SD_OK : sd_afr_delay_init(delay, &config);
}

sd_result_t sd_stage_mixture_init(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    memset(self, 0, sizeof *self);
    if (page->afr.present == 0u) { return SD_OK; } /* idle, and says so */
    return ((init_afr(&self->afr, page, p) == SD_OK) && (init_delay(&self->delay, page) == SD_OK)) ? SD_OK : SD_ERR_CONFIG;
}

sd_result_t sd_stage_mixture_configure(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p) {
    return (page->afr.present == 0u) ? SD_OK : init_afr(&self->afr, page, p);
}

void sd_stage_mixture_restart(sd_stage_mixture_t *self) {
    sd_afr_restart(&self->afr);
    sd_afr_delay_restart(&self->delay);
    self->waiting_count = 0;
}

/* ---- a tooth --------------------------------------------------------------------------------------------------- */

void sd_stage_mixture_sample(sd_stage_mixture_t *self, float lambda, float stoichiometric) {
    self->burned_sum += (1.0f + stoichiometric) / (1.0f + stoichiometric * lambda);
    self->burned_count++;
    self->cycle_samples++;
}

void sd_stage_mixture_pressure(sd_stage_mixture_t *self, float bar) {
    self->pressure_sum += bar;
    self->pressure_count++;
}

bool sd_stage_mixture_takes_pressure(const sd_stage_mixture_t *self) {
    return ready(self) && !is_told(self) && (self->afr.config.gain_mass > 0.0f);
}

static void wait_for(sd_stage_mixture_t *self, float burned, float bar) {
    if (self->waiting_count == SD_MIXTURE_WAITING) { return; } /* coasted over half a wheel: the angle is about to be lost */
    const uint32_t at = (self->waiting_first + self->waiting_count) % SD_MIXTURE_WAITING;
    self->waiting[at] = burned;
    self->waiting_bar[at] = bar;
    self->waiting_count++;
}

static void step(sd_stage_mixture_t *self, const sd_afr_tables_t *tables, uint32_t position, float burned, float bar) {
    sd_afr_step(&self->afr, tables, position, burned, bar);
    sd_afr_delay_step(&self->delay, &self->afr.in, position, 1.0f - burned); /* no sample is none there either */
}

static void step_oldest(sd_stage_mixture_t *self, const sd_afr_tables_t *tables) {
    const uint32_t position = self->waiting_position;
    const float burned = self->waiting[self->waiting_first], bar = self->waiting_bar[self->waiting_first];
    self->waiting_position = (uint16_t)((position + 1u == self->afr.config.cycle_positions) ? 0u : position + 1u);
    self->waiting_first = (uint8_t)((self->waiting_first + 1u) % SD_MIXTURE_WAITING);
    self->waiting_count--;
    step(self, tables, position, burned, bar);
}

static float take_mean(float *sum, uint32_t *count, bool wanted, float otherwise) {
    const float mean = ((*count > 0u) && wanted) ? *sum / (float)*count : otherwise;
    *sum = 0.0f;
    *count = 0;
    return mean;
}

bool sd_stage_mixture_tooth(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth, uint32_t most) {
    const bool single = tooth->advance == 1u; /* across a mark the mean belongs to no one position */
    const float burned = take_mean(&self->burned_sum, &self->burned_count, single, SD_AFR_NO_SAMPLE);
    const float bar = take_mean(&self->pressure_sum, &self->pressure_count, single, 0.0f);
    if (!ready(self)) { return false; }
    const sd_afr_tables_t tables = tables_of(page);
    if ((self->waiting_count == 0u) && single && (most > 0u)) {
        step(self, &tables, tooth->cycle_position, burned, bar);
        return false;
    }
    if (self->waiting_count == 0u) {
        const uint32_t cycle = 2u * page->positions;
        self->waiting_position = (uint16_t)((tooth->cycle_position + cycle + 1u - tooth->advance) % cycle);
    }
    for (uint32_t left = tooth->advance; left > 1u; --left) { wait_for(self, SD_AFR_NO_SAMPLE, 0.0f); }
    wait_for(self, burned, bar);
    for (uint32_t i = 0; (i < most) && (self->waiting_count > 0u); ++i) { step_oldest(self, &tables); }
    return most > 1u;
}

/* ---- the end of a cycle ---------------------------------------------------------------------------------------- */

/* Trims of a cycle ago reach the sensor about now: the filter need not find out what is known. */
static void tell_trims(sd_stage_mixture_t *self, const float *trim) {
    for (uint32_t i = 0; i < self->afr.config.cylinders; ++i) {
        if (is_told(self)) { sd_afr_trimmed(&self->afr, i, (1.0f + trim[i]) / (1.0f + self->last_trim[i])); }
        self->last_trim[i] = trim[i];
    }
}

static void learn_delay(sd_stage_mixture_t *self, const sd_parameters_t *p, float speed_radps, bool steady) {
    const float s = p->afr_stoichiometric, mean = self->afr.mean_lambda;
    /* More fuel is more gas, too; and recirculated gas has no fuel of this cycle. */
    const float of_lambda = (1.0f - mean / (1.0f + s)) * (1.0f - self->afr.egr_share);
    float trim[SD_BALANCE_CYLINDERS_MAX] = { 0.0f };
    for (uint32_t i = 0; i < self->afr.config.cylinders; ++i) { trim[i] = of_lambda * self->last_trim[i] / (1.0f + self->last_trim[i]); }
    const sd_afr_trims_t cycle = { .speed_radps = speed_radps, .trim = trim, .mean_lambda = mean, .steady = steady ? 1u : 0u };
    (void)sd_afr_delay_cycle(&self->delay, &cycle);
}

/* A filter that ran with a wrong phase begins anew with the right one. */
static bool take_over(sd_stage_mixture_t *self, const sd_parameters_t *p, float speed_radps, const sd_afr_learned_t *learned) {
    const float moved = speed_radps * (learned->late_s - self->afr.known.late_s);
    sd_afr_learned_t known = *learned; /* what the calibration is sure of nobody need learn */
    if (!(known.late_sd_s < p->afr_delay_error_sd_s)) { known.late_sd_s = p->afr_delay_error_sd_s; }
    if (!(known.lag_sd < p->afr_lag_error_sd)) { known.lag_sd = p->afr_lag_error_sd; }
    sd_afr_correct(&self->afr, &known);
    if ((moved > -MENDED_RAD) && (moved < MENDED_RAD)) { return false; }
    sd_afr_restart(&self->afr);
    return true;
}

sd_result_t sd_stage_mixture_resume(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_parameters_t *p,
                                    const sd_afr_kept_t *kept) {
    if (!ready(self) || (self->delay.config.cylinders == 0u)) { return SD_OK; }
    if (sd_afr_delay_resume(&self->delay, page->afr.dead_s, kept) != SD_OK) { return SD_ERR_CONFIG; }
    if (p->afr_delay_learning >= 0.5f) { (void)take_over(self, p, 0.0f, &self->delay.learned); } /* at rest nothing is under way */
    return SD_OK;
}

void sd_stage_mixture_keep(const sd_stage_mixture_t *self, const sd_calibration_t *page, sd_afr_kept_t *kept) {
    memset(kept, 0, sizeof *kept);
    if (self->delay.config.cylinders != 0u) { sd_afr_delay_keep(&self->delay, page->afr.dead_s, kept); }
}

static bool wants_probe(const sd_stage_mixture_t *self, const sd_parameters_t *p, const sd_mixture_cycle_t *cycle) {
    return (p->afr_delay_learning > 1.5f) && (self->probe_done == 0u) && (self->afr.slow == 0u) &&
           (cycle->diverged ||
            ((cycle->trims_learned > PROBE_AFTER) && (self->delay.learned.late_sd_s * cycle->speed_radps > KNOWN_RAD)));
}

bool sd_stage_mixture_learn(sd_stage_mixture_t *self, const sd_parameters_t *p, const sd_mixture_cycle_t *cycle) {
    sd_afr_delay_t *delay = &self->delay;
    if (!ready(self)) { return false; }
    tell_trims(self, cycle->trim);
    if ((delay->config.cylinders == 0u) || (p->afr_delay_learning < 0.5f)) {
        sd_afr_delay_probe(delay, false);
        return take_over(self, p, cycle->speed_radps, &(sd_afr_learned_t){ .late_sd_s = 1.0f, .lag_sd = 1.0f });
    }
    const bool steady = cycle->steady && (sd_afr_status(&self->afr).health != (uint8_t)SD_INVALID);
    const bool probed = delay->probed != 0u;
    learn_delay(self, p, cycle->speed_radps, steady);
    const bool mended = take_over(self, p, cycle->speed_radps, &delay->learned);
    if (!cycle->trimming) { self->probe_done = 0; }
    if (probed && (delay->probed == 0u)) { self->probe_done = 1; }
    sd_afr_delay_probe(delay, cycle->trimming && steady && ((delay->probed != 0u) || wants_probe(self, p, cycle)));
    return mended;
}

/* Share of a change that the estimate takes up in a cycle: from its variance before and after, and its drift. */
static float follows(sd_stage_mixture_t *self, float sd) {
    if (!is_told(self)) { return CHAIN_FOLLOWS; }
    const float drift = sd_afr_drift(&self->afr);
    const float before = self->last_variance + drift * drift;
    self->last_variance = sd * sd;
    return sd_clamp(1.0f - sd * sd / before, FOLLOW_LEAST, 1.0f);
}

/* Fresh air and fuel of one cylinder and cycle, mg; 0: not known. */
static float fresh_mg(const sd_stage_mixture_t *self, const sd_mixture_egr_t *egr) {
    const sd_afr_conditions_t *at = egr->at;
    if (egr->air_gps > 0.0f) {
        return 2000.0f * SD_TWO_PI * egr->air_gps / (at->speed_radps * (float)self->afr.config.cylinders) + at->fuel_mg;
    }
    const bool found = (self->afr.cycles > EGR_AFTER) && (self->afr.mean_lambda > LEAST_BURNED);
    return found ? (1.0f + egr->stoichiometric) * at->fuel_mg / self->afr.mean_lambda : 0.0f;
}

float sd_stage_mixture_recirculated(sd_stage_mixture_t *self, const sd_calibration_t *page, const sd_mixture_egr_t *egr) {
    const sd_afr_conditions_t *at = egr->at;
    const bool moving = ready(self) && (at->speed_radps > 1.0f) && (at->intake_bar > 0.0f) && (at->fuel_mg > 0.0f);
    if (!moving || !(egr->opening > EGR_OPEN)) {
        self->egr_share = 0.0f;
        return 0.0f;
    }
    const float fresh = fresh_mg(self, egr), all = 1e6f * page->afr.air_kg_per_bar * at->intake_bar + at->fuel_mg;
    if (fresh > 0.0f) { self->egr_share += EGR_PACE * (sd_clamp(1.0f - fresh / all, 0.0f, SD_AFR_EGR_MAX) - self->egr_share); }
    return self->egr_share;
}

void sd_stage_mixture_read(sd_stage_mixture_t *self, const sd_afr_conditions_t *at, sd_mixture_out_t *out) {
    memset(out, 0, sizeof *out);
    if (!ready(self)) {
        out->status = (sd_status_t){ .health = SD_INVALID, .why = SD_WHY_UNCALIBRATED };
        out->deviations.health = SD_INVALID;
        return;
    }
    sd_afr_cycle(&self->afr, at);
    out->status = sd_afr_status(&self->afr);
    if (self->cycle_samples == 0u) { sd_status_worst_of(&out->status, SD_INVALID, SD_WHY_NO_INPUT); }
    self->cycle_samples = 0;
    sd_afr_estimate_t estimate;
    sd_afr_read(&self->afr, &estimate);
    memcpy(out->burned, estimate.lambda, sizeof out->burned);
    memcpy(out->deviations.value, estimate.deviation, sizeof out->deviations.value);
    memcpy(out->deviations.sd, estimate.sd, sizeof out->deviations.sd);
    out->deviations.follow = follows(self, out->deviations.sd[0]);
    out->deviations.told = is_told(self) ? 1u : 0u;
    out->deviations.health = out->status.health;
}

bool sd_stage_mixture_work(sd_stage_mixture_t *self, const sd_calibration_t *page) {
    const sd_afr_tables_t tables = tables_of(page);
    return ready(self) && sd_afr_work(&self->afr, &tables);
}

void sd_stage_mixture_probe(const sd_stage_mixture_t *self, float size, float *trim) {
    for (uint32_t i = 0; i < SD_BALANCE_CYLINDERS_MAX; ++i) {
        trim[i] = (i < self->delay.config.cylinders) ? size * sd_afr_delay_probe_trim(&self->delay, i) : 0.0f;
    }
}
