/* SPDX-License-Identifier: MIT */
#include "sd_cusum.h"

#include <string.h>

#include "sd_math.h"

#define NUMBER_MAX 1e6f

bool sd_cusum_tables_ok(const sd_cusum_tables_t *t) {
    bool ok = (t->hypotheses >= 1u) && (t->hypotheses <= (uint8_t)SD_CUSUM_HYPOTHESES_MAX) && (t->residuals >= 1u) &&
              (t->residuals <= (uint8_t)SD_CUSUM_RESIDUALS_MAX);
    for (uint32_t l = 0; ok && (l < t->hypotheses); ++l) {
        ok = (t->group[l] < 8u) && sd_above_to(t->offset[l], 0.0f, NUMBER_MAX);
        for (uint32_t i = 0; i < (uint32_t)SD_CUSUM_RESIDUALS_MAX; ++i) { ok = ok && sd_within(t->weight[l][i], -NUMBER_MAX, NUMBER_MAX); }
    }
    return ok;
}

bool sd_cusum_thresholds_ok(const sd_cusum_thresholds_t *t) {
    return sd_above_to(t->detect, 0.0f, 1e4f) && sd_above_to(t->isolate, 0.0f, 1e4f);
}

void sd_cusum_start(sd_cusum_t *self) { memset(self, 0, sizeof *self); }

/* The largest sum, and the largest of all others but it. */
static uint32_t largest(const sd_cusum_t *self, const sd_cusum_tables_t *tables, float *second) {
    uint32_t best = 0;
    *second = 0.0f;
    for (uint32_t l = 1; l < tables->hypotheses; ++l) {
        const uint32_t lower = (self->g[l] > self->g[best]) ? best : l;
        if (self->g[lower] > *second) { *second = self->g[lower]; }
        if (lower == best) { best = l; }
    }
    return best;
}

void sd_cusum_read(const sd_cusum_t *self, const sd_cusum_tables_t *tables, const sd_cusum_thresholds_t *thresholds, sd_cusum_out_t *out) {
    float second;
    const uint32_t best = largest(self, tables, &second);
    memset(out, 0, sizeof *out);
    for (uint32_t l = 0; l < tables->hypotheses; ++l) {
        const float other = (l == best) ? second : self->g[best];
        const float detected = self->g[l] - thresholds->detect, isolated = self->g[l] - other - thresholds->isolate;
        out->decision[l] = (detected < isolated) ? detected : isolated;
        if (detected > 0.0f) { out->groups = (uint8_t)(out->groups | (1u << tables->group[l])); }
    }
    if (out->decision[best] > 0.0f) {
        out->named = (uint8_t)(best + 1u);
        out->since_steps = self->n[best];
    }
}

/* The largest sum grows to a bound, so that a fault that ends is soon no longer named. The others go down with it, so that it stays as far
 * above them, but no further than to where they are above `detect` still. */
static void bound(sd_cusum_t *self, const sd_cusum_tables_t *tables, const sd_cusum_thresholds_t *thresholds) {
    float second;
    const float above = self->g[largest(self, tables, &second)] - 2.0f * (thresholds->detect + thresholds->isolate);
    const float least = 1.5f * thresholds->detect;
    if (!(above > 0.0f)) { return; }
    for (uint32_t l = 0; l < tables->hypotheses; ++l) {
        const float lower = self->g[l] - above;
        if (self->g[l] > least) { self->g[l] = (lower > least) ? lower : least; }
    }
}

void sd_cusum_step(sd_cusum_t *self, const sd_cusum_tables_t *tables, const sd_cusum_thresholds_t *thresholds, const float *residual,
                   sd_cusum_out_t *out) {
    for (uint32_t l = 0; l < tables->hypotheses; ++l) {
        float sum = self->g[l] - tables->offset[l];
        for (uint32_t i = 0; i < tables->residuals; ++i) { sum += tables->weight[l][i] * residual[i]; }
        self->g[l] = sum;
        if (!(sum > 0.0f)) {
            self->g[l] = 0.0f; /* NaN too */
            self->n[l] = 0;
        } else if (self->n[l] < UINT32_MAX) {
            self->n[l]++;
        }
    }
    bound(self, tables, thresholds);
    sd_cusum_read(self, tables, thresholds, out);
}
