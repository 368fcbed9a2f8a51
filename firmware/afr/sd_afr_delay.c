/* SPDX-License-Identifier: MIT */
#include "sd_afr_delay.h"

#include <string.h>

#include "sd_math.h"

enum { CYCLES_MIN = 20,  /* in a fit */
       CYCLES_MAX = 400,
       PROBE_MAX = 600,
       PROBE_END = 60,   /* in the last of them a coarse answer is better than none */
       SKIP_MIN = 3 };   /* cycles after a step until its gas has arrived */

#define STEP           0.01f          /* change of a trim in a cycle above which it is a step */
#define SETTLED_LAGS   5.0f           /* sums of the lags until the mean has settled */
#define SD_PASSIVE_RAD 0.1f           /* of arg R, in the fit, for it to be taken: 11 deg crank; at the end of a probe, too */
#define SD_PROBE_RAD   0.04f
#define OFF_PASSIVE_RAD 0.1f          /* what the model itself may be off by: trims reach cylinders within a cycle */
#define OFF_PROBE_RAD  0.03f
/* Square of a reading over its variance for it to be taken without a probe, or against an earlier start. */
#define CLEAR          6.25f
#define SQUARE_LOW     0.25f          /* of |R|, outside of which it is no answer to the trims */
#define SQUARE_HIGH    4.0f
#define LATE_SD_S      0.01f          /* before anything was learned */
#define LAG_SD         0.2f
#define OFF_PACE       0.25f          /* of the mean of what the fit leaves of each cycle */
#define MOVED          (16.0f * OFF_PACE / (2.0f - OFF_PACE)) /* the square of that mean over its usual one: four deviations */
#define AGEING         1.1f           /* of a variance, with each fit */
#define LATE_MAX_S     0.05f
#define LAG_MAX        0.5f

/* Sine and cosine of a small angle. */
static void unit(float x, float *cosine, float *sine) {
    const float s = x * x;
    *cosine = 1.0f - s * (0.5f - s * (1.0f / 24.0f - s * (1.0f / 720.0f)));
    *sine = x * (1.0f - s * (1.0f / 6.0f - s * (1.0f / 120.0f - s * (1.0f / 5040.0f))));
}

/* To 7e-4 rad. */
static float angle_of(float re, float im) {
    const float a = (re < 0.0f) ? -re : re, b = (im < 0.0f) ? -im : im;
    const float t = ((a > b) ? b : a) / ((a > b) ? a : b), s = t * t;
    float angle = t * (0.995354f - s * (0.288679f - s * 0.079331f));
    if (b > a) { angle = 0.25f * SD_TWO_PI - angle; }
    if (re < 0.0f) { angle = 0.5f * SD_TWO_PI - angle; }
    return (im < 0.0f) ? -angle : angle;
}

sd_result_t sd_afr_delay_init(sd_afr_delay_t *self, const sd_afr_delay_config_t *c) {
    const bool ok = (c->cycle_positions >= 24u) && (c->cycle_positions <= SD_AFR_POSITIONS_MAX) && (c->cylinders >= 2u) &&
                    (c->cylinders <= SD_AFR_CYLINDERS_MAX) && sd_within(c->tau1_s, 1e-4f, 1.0f) && sd_within(c->tau2_s, 1e-4f, 1.0f);
    if (!ok) { return SD_ERR_CONFIG; }
    memset(self, 0, sizeof *self);
    self->config = *c;
    self->learned = (sd_afr_learned_t){ .late_sd_s = LATE_SD_S, .lag_sd = LAG_SD };
    unit(SD_TWO_PI / (float)c->cycle_positions, &self->turn[0], &self->turn[1]);
    return SD_OK;
}

/* Something was learned: only then is there anything to carry over to another calibration. */
static bool is_known(float sd, float unknown_sd) { return (sd > 0.0f) && (sd < unknown_sd); }

sd_result_t sd_afr_delay_resume(sd_afr_delay_t *self, float dead_s, const sd_afr_kept_t *kept) {
    const sd_afr_learned_t *was = &kept->learned;
    const float lags = kept->tau1_s + kept->tau2_s, lags_now = self->config.tau1_s + self->config.tau2_s;
    if ((lags == 0.0f) && (kept->dead_s == 0.0f)) { return SD_OK; }
    if (!sd_within(kept->tau1_s, 1e-4f, 1.0f) || !sd_within(kept->tau2_s, 1e-4f, 1.0f)
        || !sd_within(was->lag_sd, 0.0f, 10.0f)) { return SD_ERR_CONFIG; }
    sd_afr_learned_t now = { .late_sd_s = LATE_SD_S, .lag_sd = LAG_SD };
    if (is_known(was->late_sd_s, LATE_SD_S)) {
        now.late_s = was->late_s + kept->dead_s - dead_s;
        now.late_sd_s = was->late_sd_s;
    }
    if (is_known(was->lag_sd, LAG_SD)) {
        now.lag = (1.0f + was->lag) * lags / lags_now - 1.0f;
        now.lag_sd = was->lag_sd;
    }
    if (!sd_within(now.late_s, -LATE_MAX_S, LATE_MAX_S) || !sd_within(now.lag, -LAG_MAX, LAG_MAX)) { return SD_ERR_CONFIG; }
    self->learned = now;
    self->unproven = 1;
    return SD_OK;
}

void sd_afr_delay_keep(const sd_afr_delay_t *self, float dead_s, sd_afr_kept_t *kept) {
    *kept = (sd_afr_kept_t){ .learned = self->learned, .dead_s = dead_s, .tau1_s = self->config.tau1_s, .tau2_s = self->config.tau2_s };
}

/* The trims' own composition at the sensor. */
static void answer(sd_afr_delay_t *self, const sd_afr_inflow_t *in) {
    const uint32_t count = in->count;
    float x = self->x;
    if (count > 0u) {
        float sum = 0.0f;
        for (uint32_t k = 0; k < count; ++k) { sum += in->added[k] * self->trim[in->cylinder[k]]; }
        x = in->kept * x + in->per_mass * sum;
        self->x = x;
    }
    self->lag2 += self->move2 * (x - self->lag2);
    self->lag1 += self->move1 * (self->lag2 - self->lag1);
}

void sd_afr_delay_step(sd_afr_delay_t *self, const sd_afr_inflow_t *in, uint32_t cycle_position, float measured) {
    if (self->set == 0u) { return; }
    answer(self, in);
    float re = 1.0f, im = 0.0f;
    if (cycle_position != 0u) {
        re = self->phase[0] * self->turn[0] - self->phase[1] * self->turn[1];
        im = self->phase[0] * self->turn[1] + self->phase[1] * self->turn[0];
    }
    self->phase[0] = re;
    self->phase[1] = im;
    if ((measured > -2.0f) && (measured < 2.0f)) {
        self->last_seen = 1.0f - measured;
        self->last_told = self->lag1;
        self->sum += self->last_seen;
        self->samples++;
    }
    const float differs = self->last_seen - self->level, told = self->last_told;
    self->seen[0] += differs * re;
    self->seen[1] -= differs * im;
    self->told[0] += told * re;
    self->told[1] -= told * im;
}

static void forget(sd_afr_delay_t *self) {
    self->seen_square = self->told_square = self->cross[0] = self->cross[1] = 0.0f;
    self->usual_seen[0] = self->usual_seen[1] = self->usual_told[0] = self->usual_told[1] = 0.0f;
    self->off[0] = self->off[1] = 0.0f;
    self->cycles = 0;
}

void sd_afr_delay_restart(sd_afr_delay_t *self) {
    forget(self);
    self->skip = SKIP_MIN;
    self->probed = 0;
}

static float square_of(const float *x) { return x[0] * x[0] + x[1] * x[1]; }

/* Cycles that neither the fit nor any answer to the trims explains: an injector has moved, so the constant is another one. */
static bool moved_by_itself(sd_afr_delay_t *self) {
    if (self->cycles < CYCLES_MIN) { return false; }
    const float y[2] = { self->seen[0] - self->usual_seen[0], self->seen[1] - self->usual_seen[1] };
    const float p[2] = { self->told[0] - self->usual_told[0], self->told[1] - self->usual_told[1] };
    const float inverse = (self->told_square > 0.0f) ? 1.0f / self->told_square : 0.0f;
    const float re = self->cross[0] * inverse, im = self->cross[1] * inverse;
    const float off[2] = { y[0] - re * p[0] + im * p[1], y[1] - re * p[1] - im * p[0] };
    const float left = self->seen_square - square_of(self->cross) * inverse, usual = ((left > 0.0f) ? left : 0.0f) / (float)self->cycles;
    for (uint32_t k = 0; k < 2u; ++k) { self->off[k] += OFF_PACE * (off[k] - self->off[k]); }
    return square_of(self->off) > MOVED * usual + SQUARE_HIGH * square_of(p);
}

/* Least squares with a constant, cycle by cycle; what is older than CYCLES_MAX fades. */
static void gather(sd_afr_delay_t *self) {
    const float keep = (self->cycles < CYCLES_MAX) ? 1.0f : 1.0f - 1.0f / (float)CYCLES_MAX;
    if (self->cycles < CYCLES_MAX) { self->cycles++; }
    const float pace = 1.0f / (float)self->cycles, weight = 1.0f - pace;
    float y[2], p[2];
    for (uint32_t k = 0; k < 2u; ++k) {
        y[k] = self->seen[k] - self->usual_seen[k];
        p[k] = self->told[k] - self->usual_told[k];
        self->usual_seen[k] += pace * y[k];
        self->usual_told[k] += pace * p[k];
    }
    self->seen_square = keep * self->seen_square + weight * (y[0] * y[0] + y[1] * y[1]);
    self->told_square = keep * self->told_square + weight * (p[0] * p[0] + p[1] * p[1]);
    self->cross[0] = keep * self->cross[0] + weight * (y[0] * p[0] + y[1] * p[1]);
    self->cross[1] = keep * self->cross[1] + weight * (y[1] * p[0] - y[0] * p[1]);
}

/* A and B of the header, from w tau of both lags. */
static void sensor(float wt1, float wt2, float *shrinks, float *turns) {
    const float part1 = wt1 / (1.0f + wt1 * wt1), part2 = wt2 / (1.0f + wt2 * wt2);
    *shrinks = wt1 * part1 + wt2 * part2;
    *turns = part1 + part2;
}

float sd_afr_delay_doubt(const sd_afr_learned_t *known, float speed_radps, float tau1_s, float tau2_s) {
    float shrinks, turns;
    sensor(0.5f * speed_radps * tau1_s, 0.5f * speed_radps * tau2_s, &shrinks, &turns);
    const float turned = 0.5f * speed_radps * known->late_sd_s;
    return (shrinks * shrinks + turns * turns) * known->lag_sd * known->lag_sd + turned * turned;
}

/* One reading, weighed against what is known. What the model is off by is in all readings alike. */
static void weigh(float *value, float *sd, float reading_off, float noise_var, float model_var, float most) {
    const float known = AGEING * *sd * *sd, gain = known / (known + noise_var + model_var), left = known - gain * known;
    const float moved = *value + gain * reading_off, var = (left > model_var) ? left : model_var;
    *value = sd_clamp(moved, -most, most);
    *sd = sd_root(var);
}

/* What an earlier start knew, and this one does not find, counts no more. */
static float deviation_known(const sd_afr_delay_t *self, float sd, float unknown_sd, float reading_off, float reading_var) {
    const bool disproved = (self->unproven != 0u) && (reading_off * reading_off > CLEAR * reading_var);
    return disproved ? unknown_sd : sd;
}

/* Takes the fit over once it is sharp enough. */
static bool learn(sd_afr_delay_t *self, float speed_radps) {
    const bool probing = self->probed > 0u;
    if ((self->cycles < CYCLES_MIN) || !(self->told_square > 0.0f)) { return false; }
    const float inverse = 1.0f / self->told_square, re = self->cross[0] * inverse, im = self->cross[1] * inverse;
    const float square = re * re + im * im, left = self->seen_square * inverse - square;
    const float variance = ((left > 0.0f) ? left : 0.0f) / (2.0f * (float)self->cycles * square); /* of arg R and of ln|R| */
    const float limit = (probing && (self->probed < PROBE_MAX - PROBE_END)) ? SD_PROBE_RAD : SD_PASSIVE_RAD;
    const float off = probing ? OFF_PROBE_RAD : OFF_PASSIVE_RAD, model = off * off, angle = angle_of(re, im);
    if (!(variance < limit * limit) || !sd_within(square, SQUARE_LOW, SQUARE_HIGH)) { return false; }
    if (!probing && (angle * angle < CLEAR * (variance + model))) {
        self->unproven = 0;
        return false;
    }
    const float longer_by = 1.0f + self->learned.lag;
    float shrinks, turns;
    sensor(0.5f * speed_radps * self->config.tau1_s * longer_by, 0.5f * speed_radps * self->config.tau2_s * longer_by, &shrinks, &turns);
    const float before = self->learned.lag, size = sd_root(square);
    if (probing) {
        const float longer = -2.0f * (size - 1.0f) / ((size + 1.0f) * shrinks); /* -ln|R|/A */
        const float noise_var = variance / (shrinks * shrinks), model_var = model / (shrinks * shrinks);
        self->learned.lag_sd = deviation_known(self, self->learned.lag_sd, LAG_SD, longer, noise_var + model_var);
        weigh(&self->learned.lag, &self->learned.lag_sd, longer, noise_var, model_var, LAG_MAX);
    }
    const float lag_var = probing ? variance * turns * turns / (shrinks * shrinks) : 0.0f; /* what of it comes in by the lag */
    const float scale = 2.0f / speed_radps, later = -scale * (angle + turns * (self->learned.lag - before));
    const float noise_var = scale * scale * (variance + lag_var), model_var = scale * scale * model;
    self->learned.late_sd_s = deviation_known(self, self->learned.late_sd_s, LATE_SD_S, later, noise_var + model_var);
    weigh(&self->learned.late_s, &self->learned.late_sd_s, later, noise_var, model_var, LATE_MAX_S);
    self->unproven = 0;
    forget(self); /* the model answers otherwise from now on */
    if (probing) { self->probed = 0; }
    return true;
}

/* Trims of what comes in from now on. True: more than a usual move, and some of it may have come already. */
static bool take_trims(sd_afr_delay_t *self, const sd_afr_trims_t *now) {
    bool stepped = false;
    for (uint32_t i = 0; i < self->config.cylinders; ++i) {
        const float trim = now->trim[i] * now->mean_lambda, most = STEP * now->mean_lambda;
        stepped = stepped || !sd_within(trim - self->trim[i], -most, most);
        self->trim[i] = trim;
    }
    return stepped;
}

static void set_pace(sd_afr_delay_t *self, float speed_radps) {
    const float step_s = 2.0f * SD_TWO_PI / (speed_radps * (float)self->config.cycle_positions), longer = 1.0f + self->learned.lag;
    const float lags = (self->config.tau1_s + self->config.tau2_s) * speed_radps * (1.0f / (2.0f * SD_TWO_PI)); /* cycles */
    self->move2 = sd_lag_move(step_s / (self->config.tau2_s * longer));
    self->move1 = sd_lag_move(step_s / (self->config.tau1_s * longer));
    self->settles = (uint16_t)(SKIP_MIN + sd_real_floor_f32(SETTLED_LAGS * lags));
    self->set = 1;
}

static bool usable(const sd_afr_delay_t *self, const sd_afr_trims_t *cycle) {
    bool ok = sd_within(cycle->speed_radps, 1.0f, 2000.0f) && sd_within(cycle->mean_lambda, 0.02f, 2.0f);
    for (uint32_t i = 0; i < self->config.cylinders; ++i) { ok = ok && sd_within(cycle->trim[i], -1.0f, 1.0f); }
    return ok;
}

bool sd_afr_delay_cycle(sd_afr_delay_t *self, const sd_afr_trims_t *cycle) {
    const bool whole = (self->samples > 0u) && (self->samples == self->last_samples), ok = usable(self, cycle);
    bool learned = false;
    if (ok) { set_pace(self, cycle->speed_radps); }
    if (!ok || (cycle->steady == 0u)) {
        self->skip = SKIP_MIN;
    }
    if (ok && take_trims(self, cycle)) {
        self->skip = self->settles;
    } else if (self->skip > 0u) {
        self->skip--;
    } else if (whole && moved_by_itself(self)) {
        forget(self);
        self->skip = self->settles;
    } else if (whole) {
        gather(self);
        learned = learn(self, cycle->speed_radps);
    }
    if (learned) { self->skip = SKIP_MIN; } /* the delay jumps */
    if (self->probed > 0u) { self->probed = (uint16_t)((self->probed < PROBE_MAX) ? self->probed + 1u : 0u); }
    self->last_samples = self->samples;
    self->level = (self->samples > 0u) ? self->sum / (float)self->samples : self->level;
    self->samples = 0;
    self->sum = self->seen[0] = self->seen[1] = self->told[0] = self->told[1] = 0.0f;
    return learned;
}

void sd_afr_delay_probe(sd_afr_delay_t *self, bool on) {
    if (on == (self->probed > 0u)) { return; }
    if (on) { forget(self); }
    self->probed = on ? 1u : 0u;
}

float sd_afr_delay_probe_trim(const sd_afr_delay_t *self, uint32_t cylinder) {
    if (self->probed == 0u) { return 0.0f; }
    const float sign = (((self->probed - 1u) / (2u * self->settles + 2u)) % 2u == 0u) ? 1.0f : -1.0f;
    return (cylinder == 0u) ? sign : -sign / (float)(self->config.cylinders - 1u);
}
