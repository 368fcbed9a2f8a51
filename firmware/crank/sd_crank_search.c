/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "sd_crank_parts.h"

/* A gap stands out against both its neighbours. Each gap is followed as one mark or another; the one that comes again
 * after as many edges as the wheel has teeth there, and as wide, is the mark. No clock is needed for that. */

enum {
    Q8           = 256,
    GAP_LEAST    = (14 * Q8) / 10, /* width of a gap over the mean of its neighbours */
    GAP_MOST     = 7 * Q8,
    MISSING_FROM = (175 * Q8) / 100, /* from here on a gap may be missing teeth */
    RIVAL_PARTS  = 4,                /* a rival is as wide as 4/5 of the other */
};

#define SLACK   2u /* edges by which a count over faults may be wrong */
#define SETTLED 3u /* further hits after which the widest wins */

typedef struct sd_gap {
    bool     seen, noisy;
    bool     pair;        /* two, with one tooth between them */
    uint32_t width, side; /* Q8 */
    uint32_t tolerance;   /* widths within this factor are alike, Q8 */
} sd_gap_t;

void sd_search_begin(sd_crank_t *self) {
    memset(self->sight, 0, sizeof self->sight);
    memset(self->raw_period, 0, sizeof self->raw_period);
    self->slot = 0;
    self->unlearned = self->teeth;
    self->fault_age = 255;
    self->noise = self->hum = self->mean = self->uneven = 0;
    self->gap_age = 0;
    self->grown_now = self->grown_before = 0;
}

/* ---- what the newest intervals say ----------------------------------------------------------------------------- */

/* Every interval has its place in the memory, which so holds the last revolution. */
static void record(sd_crank_t *self) {
    self->slot = (uint8_t)next_slot(self, self->slot);
    const uint32_t now = self->raw_period[0] << 6;
    if (self->unlearned > 0u) {
        self->unlearned--;
    } else {
        self->grown_now += (now >> 2) - (self->grown_now >> 2);
        self->grown_before += (self->memory[self->slot] >> 2) - (self->grown_before >> 2);
    }
    self->memory[self->slot] = now;
}

/* How far edges stray from even, where no gap is near. */
static void listen(sd_crank_t *self) {
    const uint32_t *q = self->raw_period;
    if (self->gap_age < 3u) { self->gap_age++; return; }
    const uint32_t bend = (uint32_t)abs32((int32_t)(2u * q[2]) - (int32_t)(q[1] + q[3])) / 2u;
    self->noise += ((bend < q[2] / 4u) ? bend : q[2] / 4u) - self->noise / 16u;
    self->hum += ((bend < q[2] / 8u) ? bend : q[2] / 8u) - self->hum / 16u;
    self->uneven += (uint32_t)abs32((int32_t)(q[2] - self->mean / 16u)) - self->uneven / 16u;
    self->mean += q[2] - self->mean / 16u;
}

/* A fading sum, 16 times a mean, over a period, Q12. */
static uint32_t over(uint32_t sum, uint32_t period) { return (sum << 4) / ((period >> 4) + 1u); }

/* A single fault among even edges does not make them noisy. */
static bool noisy(const sd_crank_t *self, uint32_t period) { return over(self->hum, period) >= (uint32_t)NOISY; }

/* What the search counts as marks: two with one tooth between them are one. */
static uint32_t marks(const sd_crank_t *self) { return self->search_marks & 15u; }

static bool stands_out(uint32_t gap, uint32_t beside) { return 10u * gap >= 13u * beside; }

#define COARSE 24u /* teeth up to which speed may change by half across three of them */

/* A gap no longer than the interval two before it may be the rest of one that a spurious edge split. The two parts then make one. On a
 * coarse wheel a crank that speeds up does the like, but there they make nearly two. */
static bool looks_split(const sd_crank_t *self) {
    const uint32_t *q = self->raw_period;
    return (5u * q[1] < 6u * q[3]) && ((self->teeth > COARSE) || (5u * (q[1] + q[2]) < 8u * q[3]));
}

/* Two gaps alike with one tooth between, and usual intervals on either side. */
static bool pair_before_last(const sd_crank_t *self) {
    const uint32_t *q = self->raw_period;
    const uint32_t most = (q[1] > q[2]) ? q[1] : q[2], least = (q[1] > q[2]) ? q[2] : q[1];
    return (q[3] > 0u) && stands_out(least, q[0]) && stands_out(least, q[3]) && (10u * most <= 17u * least);
}

static sd_gap_t gap_before_last(const sd_crank_t *self) {
    const uint32_t *q = self->raw_period;
    sd_gap_t gap = { false, false, false, 0, 0, 0 };
    gap.pair = sd_wheel_has_pairs(self) && pair_before_last(self);
    const uint32_t before = gap.pair ? q[3] : q[2], wide = gap.pair ? (q[1] + q[2]) / 2u : q[1];
    if (sd_wheel_has_pairs(self) && !gap.pair && (10u * q[0] >= 14u * q[2]) && (q[1] < 2u * q[0])) { return gap; } /* the first of a pair */
    if (!gap.pair && ((q[2] == 0u) || !stands_out(q[1], q[0]) || !stands_out(q[1], q[2]) || looks_split(self))) { return gap; }
    const uint32_t down = (wide >= (1u << 22)) ? 3u : 0u; /* so that the products fit */
    const uint32_t both = (q[0] >> down) + (before >> down);
    gap.width = ((wide >> down) * 2u * Q8) / (both + 1u);
    gap.side = ((wide >> down) * Q8) / ((before >> down) + 1u);
    const uint32_t noise = over(self->noise, (q[0] + before) / 2u);
    gap.tolerance = (12 * Q8) / 10 + noise / 4u; /* 1.2 + 4 times the noise */
    gap.noisy = noisy(self, (q[0] + before) / 2u);
    gap.seen = (gap.width >= (uint32_t)GAP_LEAST) && (gap.width <= (uint32_t)GAP_MOST);
    return gap;
}

static bool within(uint32_t a, uint32_t b, uint32_t factor_q8) { return (a * Q8 <= b * factor_q8) && (b * Q8 <= a * factor_q8); }

/* ---- gaps followed --------------------------------------------------------------------------------------------- */

static uint32_t next_mark(const sd_crank_t *self, uint32_t mark) { return (mark + 1u < self->mark_count) ? mark + 1u : 0u; }
/* The next mark that is followed: of a pair the second. */
static uint32_t mark_after(const sd_crank_t *self, uint32_t mark) {
    const uint32_t next = next_mark(self, mark);
    return sd_wheel_pair_follows(self, mark) ? next_mark(self, next) : next;
}

static bool expects(const sd_crank_t *self, const sd_crank_sight_t *s, const sd_gap_t *gap) {
    const uint32_t teeth = self->mark_teeth[s->mark] + 1u; /* the gap ended an edge ago */
    const uint32_t slack = gap->noisy ? 0u : SLACK;
    if ((s->raw != teeth) && ((s->mended + slack < teeth) || (s->mended > teeth + slack))) { return false; }
    if (gap->pair != sd_wheel_pair_follows(self, s->mark)) { return false; }
    const bool same = self->mark_run[s->mark] == self->mark_run[next_mark(self, s->mark)]; /* the two of a pair are alike */
    return within(s->width, gap->width, same ? gap->tolerance : 2u * Q8);
}

static void hit(sd_crank_t *self, sd_crank_sight_t *s, const sd_gap_t *gap) {
    const bool clean = (s->raw == self->mark_teeth[s->mark] + 1u) && (gap->noisy || (self->fault_age > s->raw));
    s->clean = (uint8_t)(clean ? s->clean + 1u : 0u);
    s->mark = (uint8_t)mark_after(self, s->mark);
    s->hits = (uint8_t)(s->hits + ((s->hits < 100u) ? 1u : 0u));
    s->raw = s->mended = 1;
    s->width = (uint16_t)((s->width + gap->width) / 2u);
    s->side = (uint16_t)gap->side;
}

static void follow(sd_crank_t *self, uint32_t mark, const sd_gap_t *gap) {
    sd_crank_sight_t *at = &self->sight[0];
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; ++i) {
        sd_crank_sight_t *s = &self->sight[i];
        if ((s->hits > 0u) && (s->raw == 1u) && (s->mark == mark)) { return; }
        if ((s->hits < at->hits) || ((s->hits == at->hits) && (s->width < at->width))) { at = s; }
    }
    if ((at->hits > 1u) || ((at->hits == 1u) && (at->width > gap->width))) { return; }
    *at = (sd_crank_sight_t){ .hits = 1, .mark = (uint8_t)mark, .raw = 1, .mended = 1,
                              .width = (uint16_t)gap->width, .side = (uint16_t)gap->side };
}

static void count_on(sd_crank_t *self) {
    const uint32_t *q = self->raw_period;
    const uint32_t least = (q[0] < q[3]) ? q[0] : q[3];
    const bool split = (q[3] > 0u) && (5u * (q[1] + q[2]) < 6u * least); /* a spurious edge in the midst of an interval */
    if (split) { self->fault_age = 0; } else if (self->fault_age < 255u) { self->fault_age++; }
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; ++i) {
        sd_crank_sight_t *s = &self->sight[i];
        if (s->hits == 0u) { continue; }
        const uint32_t last = self->mark_teeth[s->mark] + 1u;
        s->raw++;
        s->mended = (uint8_t)(s->mended + (split ? 0u : 1u));
        if ((s->raw > last) && ((s->mended > last + SLACK) || (s->raw > last + 20u))) { s->hits = 0; }
    }
}

static void gap_seen(sd_crank_t *self, const sd_gap_t *gap) {
    const uint32_t missing = (gap->width >= (uint32_t)MISSING_FROM) ? (gap->width + Q8 / 2u) / Q8 - 1u : 0u;
    bool expected = false;
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; ++i) {
        sd_crank_sight_t *s = &self->sight[i];
        if (s->hits == 0u) { continue; }
        if (expects(self, s, gap)) {
            hit(self, s, gap);
            expected = true;
        } else {
            if (((RIVAL_PARTS + 1u) * gap->width > RIVAL_PARTS * (uint32_t)s->width) && (s->strange < 100u)) { s->strange++; }
            s->mended = (uint8_t)(s->mended + missing);
        }
    }
    if (!expected && (missing > 0u) && (self->sight[0].hits > 0u)) { self->fault_age = 0; }
    for (uint32_t mark = 0; mark < self->mark_count; ++mark) {
        if (sd_wheel_has_pairs(self) && (sd_wheel_begins_pair(self, mark) || (sd_wheel_ends_pair(self, mark) != gap->pair))) { continue; }
        follow(self, mark, gap);
    }
}

/* Where a wheel's marks lie nearly evenly, each can be followed as the next one with a count that is mended by a tooth. The sight
 * whose counts were right for a whole revolution is the wheel then, and one whose counts never were is not. */
static bool is_whole(const sd_crank_t *self, const sd_crank_sight_t *s) { return s->clean >= marks(self); }
static bool counts_less(const sd_crank_t *self, const sd_crank_sight_t *s, const sd_crank_sight_t *than) {
    return (marks(self) > 1u) && (s->clean == 0u) && is_whole(self, than);
}

/* Another gap that may as well be the mark. */
static bool has_rival(const sd_crank_t *self, const sd_crank_sight_t *own, uint32_t hits, bool is_noisy) {
    const bool settled = hits >= marks(self) + SETTLED;
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; ++i) {
        const sd_crank_sight_t *s = &self->sight[i];
        if ((s == own) || (s->hits == 0u) || (s->strange > own->strange) || ((s->raw == 1u) && (s->hits == 1u))) { continue; }
        if (counts_less(self, s, own)) { continue; }
        if (counts_less(self, own, s)) { return true; }
        if (settled || is_noisy ? (s->width > own->width) && (s->hits + SETTLED > hits)
                    : (RIVAL_PARTS + 1u) * s->width > RIVAL_PARTS * (uint32_t)own->width) {
            return true;
        }
    }
    return false;
}

/* ---- sync ------------------------------------------------------------------------------------------------------ */

/* The newest edge is the tooth `beyond` the first after `mark`, 0 or 1. */
typedef struct sd_found {
    uint32_t mark, beyond;
    uint32_t clean; /* gaps in a row without a fault on the way */
    uint32_t width; /* of the mark's gap, Q8 */
} sd_found_t;

/* The tooth before it is known as well, and lies before the mark where this is the first after it. */
static void describe(const sd_crank_t *self, const sd_found_t *found, sd_tooth_t *tooth) {
    const bool first = found->beyond == 0u;
    tooth->edge_class = SD_EDGE_TOOTH;
    tooth->period_ticks = self->raw_period[0];
    tooth->span_spacings = (uint32_t)(first ? self->mark_spacings[found->mark] : ONE);
    tooth->advance = (uint8_t)(first ? self->mark_run[found->mark] + 1u : 1u);
}

static void sync(sd_crank_t *self, uint32_t tick, const sd_found_t *found) {
    const uint32_t *q = self->raw_period, mark = found->mark, beyond = found->beyond;
    const bool whole = (found->clean >= marks(self)) && (self->unlearned == 0u);
    sd_track_begin(self, tick, sd_wheel_first_after(self, mark) + beyond);
    if (whole) {
        const bool quiet = !noisy(self, q[2]);
        sd_clocks_recall(self, tick, quiet ? 0u : over(self->noise, q[2]), over(self->uneven, q[2]));
        sd_wheel_measure(self, mark, (self->slot >= beyond) ? self->slot - beyond : self->teeth - 1u, quiet);
        return;
    }
    /* Faults on the way: the next mark must confirm the angle before a tooth is valid. */
    self->unsure = 1;
    self->provisional = 1;
    self->strain = ONE;
    const int32_t width = (int32_t)(found->width << 4);
    sd_wheel_set_width(self, mark, width);
    self->unlearned = self->teeth;
    const int32_t grown = ((int32_t)q[0] - (int32_t)q[2]) * 64;
    sd_clocks_start(self, tick, clamp32((int64_t)q[0] << 6, PERIOD_MIN, PERIOD_MAX), grown / ((width + ONE) >> 12));
}

/* Where edges are quiet, and nothing else on the way looked like a mark, the first tooth after it gives the angle. */
static bool find_early(const sd_crank_t *self, sd_found_t *found) {
    const uint32_t *q = self->raw_period;
    if (!stands_out(q[0], q[1])) { return false; }
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; ++i) {
        const sd_crank_sight_t *s = &self->sight[i];
        if ((s->hits < marks(self)) || (s->clean + 1u < marks(self))) { continue; }
        if ((s->raw != self->mark_teeth[s->mark]) || (self->fault_age < s->raw)) { continue; }
        const uint32_t down = (q[0] >= (1u << 22)) ? 3u : 0u;
        const uint32_t side = ((q[0] >> down) * Q8) / ((q[1] >> down) + 1u);
        if (within(side, s->side, (12 * Q8) / 10) && !noisy(self, q[1]) && !has_rival(self, s, s->hits + 1u, false)) {
            *found = (sd_found_t){ mark_after(self, s->mark), 0u, s->clean + 1u, s->width };
            return true;
        }
    }
    return false;
}

static bool find_mark(sd_crank_t *self, sd_found_t *found) {
    record(self);
    count_on(self);
    const sd_gap_t gap = gap_before_last(self);
    if (!gap.seen) {
        listen(self);
        return find_early(self, found);
    }
    self->gap_age = 0;
    gap_seen(self, &gap);
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; ++i) {
        sd_crank_sight_t *s = &self->sight[i];
        if ((s->raw != 1u) || (s->hits < 2u)) { continue; }
        if ((s->hits > marks(self)) && !has_rival(self, s, s->hits, gap.noisy)) {
            *found = (sd_found_t){ s->mark, 1u, s->clean, s->width };
            return true;
        }
        s->strange = 0;
    }
    return false;
}

bool sd_search_edge(sd_crank_t *self, uint32_t tick, uint32_t period, sd_tooth_t *tooth) {
    for (uint32_t i = 3; i > 0u; --i) { self->raw_period[i] = self->raw_period[i - 1u]; }
    self->raw_period[0] = period;
    sd_found_t found = { 0u, 0u, 0u, 0u };
    if (!find_mark(self, &found)) { return false; }
    sync(self, tick, &found);
    describe(self, &found, tooth);
    return true;
}
