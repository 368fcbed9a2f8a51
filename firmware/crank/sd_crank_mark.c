/* SPDX-License-Identifier: MIT */
#include "sd_crank_parts.h"

enum {
    SLIP_MAX        = 3,  /* teeth the vote at a mark can put right */
    VOTERS_MIN      = 5,  /* edges that make a vote */
    ASTRAY_MAX      = 1,  /* edges astray that a vote may count as faults */
    STRAY           = (35 * ONE) / 100, /* an edge further from a tooth stands astray */
    UNLEARNED       = ONE / 2,          /* scatter of a mark seen less than twice */
    STRAINED        = (16 * ONE) / 100, /* clocks this far off, on average, may have slipped */
};

/* ---- the wheel ------------------------------------------------------------------------------------------------- */

static bool is_missing(const sd_crank_config_t *config, uint32_t position) {
    for (uint32_t i = 0; i < config->missing_count; ++i) {
        if (config->missing[i] == position) { return true; }
    }
    return false;
}

/* The mark that begins right after `position`, or SD_CRANK_MARKS_MAX. */
uint32_t sd_wheel_mark_after(const sd_crank_t *self, uint32_t position) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        if (self->mark_first[m] == position + 1u) { return m; }
    }
    return SD_CRANK_MARKS_MAX;
}

uint32_t sd_wheel_first_after(const sd_crank_t *self, uint32_t mark) {
    return ((uint32_t)self->mark_first[mark] + self->mark_run[mark]) % self->config.positions;
}

bool sd_wheel_second_after(const sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        if (self->position == sd_wheel_first_after(self, m) + 1u) { return true; }
    }
    return false;
}

void sd_wheel_sum_turn(sd_crank_t *self) {
    self->turn_spacings = (self->config.positions - self->config.missing_count - self->mark_count) * ONE;
    for (uint32_t m = 0; m < self->mark_count; ++m) { self->turn_spacings += self->mark_spacings[m]; }
}

void sd_wheel_reset_widths(sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        self->mark_spacings[m] = (self->mark_run[m] + 1) * ONE;
        self->mark_scatter[m] = UNLEARNED;
    }
    sd_wheel_sum_turn(self);
}

/* 1.6 to 4.5 spacings is what real sensors make of a mark of any width. */
int32_t sd_wheel_plausible_width(int64_t spacings) { return clamp32(spacings, (16 * ONE) / 10, (45 * ONE) / 10); }

static bool collect_marks(sd_crank_t *self) {
    const sd_crank_config_t *config = &self->config;
    for (uint32_t p = 0; p < config->positions; ++p) {
        if (!is_missing(config, p)) { continue; }
        if ((p == 0u) || !is_missing(config, p - 1u)) {
            if (self->mark_count == SD_CRANK_MARKS_MAX) { return false; }
            self->mark_first[self->mark_count] = (uint8_t)p;
            self->mark_count++;
        }
        if (++self->mark_run[self->mark_count - 1u] > SD_CRANK_RUN_MAX) { return false; }
    }
    return true;
}

/* The vote needs teeth of its own on both sides of every mark. */
static bool marks_stand_apart(const sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        const uint32_t next = self->mark_first[(m + 1u) % self->mark_count];
        const uint32_t teeth = (next + self->config.positions - sd_wheel_first_after(self, m)) % self->config.positions;
        if (teeth < 4u) { return false; }
    }
    return true;
}

bool sd_wheel_find_marks(sd_crank_t *self) { return collect_marks(self) && marks_stand_apart(self); }

/* ---- the vote at a mark ---------------------------------------------------------------------------------------- */

/* How the edges around the mark fit the wheel when its mark stands `slip` teeth later than we think. */
typedef struct sd_fit {
    int32_t edges;  /* edges that were looked at */
    int32_t astray; /* of these, edges where no tooth should be */
    int32_t inside; /* of these, edges in the midst of the mark */
} sd_fit_t;

static sd_fit_t fit(const sd_crank_t *self, int32_t width, int32_t slip) {
    sd_fit_t sum = { 0, 0, 0 };
    for (uint32_t i = 0; i < self->witness_count; ++i) {
        const int32_t here = (int32_t)((uint32_t)self->witness[i] - (uint32_t)self->mark_travel);
        if ((here < -(SLIP_MAX + 2) * ONE) || (here > width + (VOTE_AFTER + 1) * ONE)) { continue; }
        const int32_t x = here - slip * ONE;
        const bool before = x < ONE / 2;
        const bool inside = !before && (x < width - ONE / 2);
        const int32_t off = (((before ? x : x - width) + ONE / 2) & (ONE - 1)) - ONE / 2;
        sum.edges++;
        sum.inside += inside ? 1 : 0;
        sum.astray += (inside || (abs32(off) > STRAY)) ? 1 : 0;
    }
    return sum;
}

static bool stands(const sd_crank_t *self, int32_t beyond_mark) {
    for (uint32_t i = 0; i < self->witness_count; ++i) {
        const int32_t here = (int32_t)((uint32_t)self->witness[i] - (uint32_t)self->mark_travel);
        if (abs32(here - beyond_mark) <= STRAY) { return true; }
    }
    return false;
}

/* The slip that leaves fewer edges astray than none does. A single edge astray speaks for a slip only where a tooth
 * beside the mark is missing as well: without a slip that takes two faults. */
static int32_t find_slip(const sd_crank_t *self, int32_t width, const sd_fit_t *here) {
    int32_t found = 0, least = here->astray;
    if ((here->astray <= 1) && stands(self, 0) && stands(self, width)) { return 0; }
    for (int32_t slip = -SLIP_MAX; slip <= SLIP_MAX; ++slip) {
        const int32_t astray = fit(self, width, slip).astray;
        if (astray < least) { least = astray; found = slip; }
    }
    return (least <= ASTRAY_MAX) ? found : 0;
}

static void angle_confirmed(sd_crank_t *self) {
    self->missed = 0;
    self->suspected_slip = 0;
    self->strain = 0;
    self->unsure = 0;
}

/* A first sight sets the scatter; later ones average. */
static void learn_mark(sd_crank_t *self, uint32_t mark) {
    if (self->mark_clean == 0u) { return; }
    int32_t *scatter = &self->mark_scatter[mark];
    const bool first = *scatter == UNLEARNED;
    const int32_t stray = self->mark_late;
    *scatter = clamp32(first ? abs32(stray) : *scatter + (abs32(stray) - *scatter) / 8, 0, UNLEARNED - 1);
    self->mark_spacings[mark] = sd_wheel_plausible_width(self->mark_spacings[mark] + stray / (first ? 2 : 8));
    sd_wheel_sum_turn(self);
}

void sd_mark_vote(sd_crank_t *self) {
    const uint32_t mark = self->pending_mark;
    const int32_t width = self->mark_spacings[mark];
    const sd_fit_t here = fit(self, width, 0);
    const int32_t slip = find_slip(self, width, &here);
    self->pending_mark = SD_CRANK_MARKS_MAX;
    if (slip != 0) {
        /* Clocks that were never far off cannot have slipped: then it takes two marks to convince us. */
        const bool believed = (self->strain > STRAINED) || (slip == self->suspected_slip);
        self->suspected_slip = (int8_t)slip;
        if (!believed) {
            self->unsure = 1;
            return;
        }
        self->position = (uint8_t)((int32_t)self->position - slip);
        self->counts.slips++;
        sd_memory_forget(self);
        angle_confirmed(self);
    } else if ((here.inside > 0) || (here.astray > ASTRAY_MAX) || (here.edges < VOTERS_MIN)) {
        self->counts.marks_missed++;
        self->missed = (uint8_t)(self->missed + 1u + self->unsure);
    } else {
        learn_mark(self, mark);
        angle_confirmed(self);
    }
}
