/* SPDX-License-Identifier: MIT */
#include "sd_crank_parts.h"

enum {
    UNLEARNED = ONE / 2, /* scatter of a mark seen less than twice */
    TEETH_MIN = 6,       /* what the smallest wheel has with two marks of three */
};

uint32_t sd_wheel_first_after(const sd_crank_t *self, uint32_t mark) {
    const uint32_t position = (uint32_t)self->mark_first[mark] + self->mark_run[mark];
    return (position < self->config.positions) ? position : 0u;
}

/* Position `teeth` teeth further on, or back when negative. */
uint32_t sd_wheel_step(const sd_crank_t *self, uint32_t position, int32_t teeth) {
    const uint32_t n = self->config.positions;
    for (; teeth > 0; --teeth) {
        const uint32_t mark = sd_wheel_mark_after(self, position);
        position = (mark < SD_CRANK_MARKS_MAX) ? sd_wheel_first_after(self, mark) : position + 1u;
    }
    for (; teeth < 0; ++teeth) {
        uint32_t before = (position > 0u) ? position - 1u : n - 1u;
        for (uint32_t m = 0; m < self->mark_count; ++m) {
            if (sd_wheel_first_after(self, m) == position) { before = (uint32_t)self->mark_first[m] - 1u; }
        }
        position = before;
    }
    return position;
}

static void sum_turn(sd_crank_t *self) {
    self->turn_spacings = (self->teeth - self->mark_count) * ONE;
    for (uint32_t m = 0; m < self->mark_count; ++m) { self->turn_spacings += self->mark_spacings[m]; }
}

void sd_wheel_reset_widths(sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        self->mark_spacings[m] = (self->mark_run[m] + 1) * ONE;
        self->mark_scatter[m] = UNLEARNED;
    }
    sum_turn(self);
}

/* 1.6 to 4.5 spacings is what real sensors make of a mark of any width. */
void sd_wheel_set_width(sd_crank_t *self, uint32_t mark, int32_t spacings) {
    self->mark_spacings[mark] = clamp32(spacings, (16 * ONE) / 10, (45 * ONE) / 10);
    sum_turn(self);
}

/* How late the tooth after the mark was against the width known so far. A first sight sets the scatter; later ones
 * average. */
void sd_wheel_learn(sd_crank_t *self, uint32_t mark, int32_t late) {
    int32_t *scatter = &self->mark_scatter[mark];
    const bool first = *scatter == UNLEARNED;
    *scatter = clamp32(first ? abs32(late) : *scatter + (abs32(late) - *scatter) / 8, 0, UNLEARNED - 1);
    sd_wheel_set_width(self, mark, self->mark_spacings[mark] + late / (first ? 2 : 8));
}

/* What a spacing would take where the mark is, from the intervals two and three away, because those beside a mark may be
 * odd, with their bend taken out: mean(2) + 1.2 (mean(2) - mean(3)). Under jitter all three on either side, as they are. Beside one
 * of a pair of marks lies the other, so two on either side, as they are. */
static int32_t spacing_at(const sd_crank_t *self, uint32_t mark, uint32_t slot, bool quiet) {
    uint32_t after = slot, before = slot, pair[3]; /* an eighth of each interval, so that sums fit */
    _Pragma("GCC unroll 3")
    for (uint32_t i = 0; i < 3u; ++i) {
        after = next_slot(self, after);
        before = (before > 0u) ? before - 1u : self->teeth - 1u;
        pair[i] = (self->memory[after] >> 3) + (self->memory[before] >> 3);
    }
    if (sd_wheel_has_pairs(self) && (sd_wheel_begins_pair(self, mark) || sd_wheel_ends_pair(self, mark))) {
        return clamp32(2 * ((int64_t)pair[1] + pair[2]), PERIOD_MIN, PERIOD_MAX);
    }
    const int64_t even = quiet ? ((int64_t)pair[1] * 2253 - (int64_t)pair[2] * 1229) >> 8 /* 2.2 and 1.2 of 1024, times 4 */
                               : ((int64_t)pair[0] + pair[1] + pair[2]) * 1365 >> 10;
    return clamp32(even, PERIOD_MIN, PERIOD_MAX);
}

/* The two of a pair are as wide as each other, and both are known better by the mean. */
static void share_width(sd_crank_t *self, uint32_t first, uint32_t second) {
    const int32_t mean = (self->mark_spacings[first] + self->mark_spacings[second]) / 2;
    sd_wheel_set_width(self, first, mean);
    sd_wheel_set_width(self, second, mean);
}

/* Every mark's width from a whole revolution in the memory; `slot` is that of the first tooth after `mark`. */
void sd_wheel_measure(sd_crank_t *self, uint32_t mark, uint32_t slot, bool quiet) {
    for (uint32_t i = 0; i < self->mark_count; ++i) {
        const sd_inverse_t inverse = sd_inverse_of(spacing_at(self, mark, slot, quiet));
        sd_wheel_set_width(self, mark, sd_in_spacings(&inverse, clamp32(self->memory[slot], 0, TIME_MAX)));
        slot += sd_wheel_teeth_after(self, mark);
        slot %= self->teeth;
        mark = (mark + 1u < self->mark_count) ? mark + 1u : 0u;
    }
    for (uint32_t m = 0; sd_wheel_has_pairs(self) && (m < self->mark_count); ++m) {
        if (sd_wheel_ends_pair(self, m)) { share_width(self, sd_wheel_mark_before(self, m), m); }
    }
}

/* ---- reading the configuration --------------------------------------------------------------------------------- */

static bool collect_marks(sd_crank_t *self) {
    const uint8_t *missing = self->config.missing;
    uint32_t mark = 0;
    self->mark_first[0] = missing[0];
    self->mark_run[0] = 1;
    for (uint32_t i = 1; i < self->config.missing_count; ++i) {
        if (missing[i] != missing[i - 1u] + 1) {
            if (++mark == SD_CRANK_MARKS_MAX) { return false; }
            self->mark_first[mark] = missing[i];
        }
        if (++self->mark_run[mark] > SD_CRANK_RUN_MAX) { return false; }
    }
    self->mark_count = (uint8_t)(mark + 1u);
    return true;
}

/* The vote needs teeth of its own on both sides of every mark; two marks with one tooth between them vote as one. */
static bool marks_stand_apart(sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        const uint32_t next = (m + 1u) % self->mark_count;
        const uint32_t teeth =
            (self->mark_first[next] + self->config.positions - sd_wheel_first_after(self, m)) % self->config.positions;
        if ((teeth < 4u) && ((teeth != 1u) || (self->mark_run[m] != self->mark_run[next]))) { return false; }
        self->mark_teeth[m] = (uint8_t)teeth;
    }
    self->search_marks = self->mark_count;
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        const uint32_t before = sd_wheel_mark_before(self, m);
        if (!sd_wheel_begins_pair(self, m)) { continue; }
        if (sd_wheel_begins_pair(self, before)) { return false; }
        self->mark_teeth[before]++;
        self->search_marks = (uint8_t)(self->search_marks - 1u + (0x10u << before));
    }
    return true;
}

/* Fills what follows from the configuration. Returns false where the marks are too many, too wide or too near. */
bool sd_wheel_init(sd_crank_t *self) {
    const int32_t teeth = (int32_t)self->config.positions - self->config.missing_count;
    if (teeth < TEETH_MIN) { return false; } /* marks would be too wide or too near */
    self->teeth = (uint8_t)teeth;
    if (!collect_marks(self) || !marks_stand_apart(self)) { return false; }
    self->mark_at = 0xffffffffu;
    for (uint32_t m = 0; m < self->mark_count; ++m) { self->mark_at ^= (0xffu ^ self->mark_first[m]) << (8u * m); }
    sd_wheel_reset_widths(self);
    return true;
}
