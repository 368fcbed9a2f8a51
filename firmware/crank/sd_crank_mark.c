/* SPDX-License-Identifier: MIT */
#include "sd_crank_parts.h"

enum {
    SLIP_MAX = 3,     /* teeth the vote at a mark can put right */
    STRAINED = (16 * ONE) / 100, /* clocks this far off, on average, may have slipped */
};
#define BEFORE     ((SLIP_MAX + 2) * ONE)
#define VOTERS_MIN 5u /* edges that make a vote */
#define ASTRAY_MAX 1u /* edges astray that a vote may count as faults */
#define STRAY      ((35u * ONE) / 100u) /* an edge further from a tooth stands astray */

/* How the edges around the mark fit the wheel where we think it is. */
typedef struct sd_vote {
    uint32_t edges;       /* edges looked at */
    uint32_t astray;      /* of these, edges where no tooth should be */
    uint32_t inside;      /* of these, edges in the midst of the mark */
    bool     left, right; /* the teeth beside the mark stand where they should */
} sd_vote_t;

SD_INLINE bool on_tooth(int32_t from_tooth, uint32_t within) {
    return (((uint32_t)from_tooth + within) & (ONE - 1u)) <= 2u * within;
}
SD_INLINE bool near(int32_t x) { return (uint32_t)x + STRAY <= 2u * STRAY; }

/* How far an edge lies beyond the tooth before the mark; whether it is near enough to vote. */
SD_INLINE bool votes(const sd_crank_t *self, uint32_t i, int32_t width, int32_t before, int32_t *here) {
    *here = (int32_t)((uint32_t)self->witness[i] - (uint32_t)self->mark_travel);
    return (uint32_t)*here + (uint32_t)before <= (uint32_t)(width + before + (VOTE_AFTER + 1) * ONE);
}

/* `before`: how far before the mark an edge counts, 1/4096 spacing. */
static sd_vote_t count(const sd_crank_t *self, int32_t width, int32_t before) {
    sd_vote_t vote = { 0u, 0u, 0u, false, false };
    for (uint32_t i = 0; i < SD_CRANK_WITNESSES; ++i) {
        int32_t here;
        if (!votes(self, i, width, before, &here)) { continue; }
        vote.edges++;
        if (here < ONE / 2) {
            if (!on_tooth(here, STRAY)) { vote.astray++; }
        } else if (here >= width - ONE / 2) {
            if (!on_tooth(minus32(here, width), STRAY)) { vote.astray++; }
        } else {
            vote.astray++;
            vote.inside++;
        }
        if (near(here)) { vote.left = true; }
        if (near(minus32(here, width))) { vote.right = true; }
    }
    return vote;
}

/* Slips of -3 to 3 teeth side by side, four bits each: one pass over the edges counts for all of them. */
#define ALL_SLIPS 0x1111111u

/* The slips with which this edge is astray. With a slip of s the mark begins s teeth later. */
static uint32_t astray_with(int32_t here, int32_t width, uint32_t within) {
    const int32_t least = clamp_in(plus32(here, ONE / 2) >> 12, -SLIP_MAX, SLIP_MAX + 1);            /* before the mark from this slip on */
    const int32_t most = clamp_in(plus32(minus32(here, width), ONE / 2) >> 12, -SLIP_MAX - 1, SLIP_MAX); /* after it up to this slip */
    const uint32_t before = ALL_SLIPS & (ALL_SLIPS << (4 * (least + SLIP_MAX))); /* by 28 at most */
    const uint32_t after = (ALL_SLIPS >> (4 * (SLIP_MAX - most))) & ~before;
    uint32_t off = ALL_SLIPS & ~(before | after);
    if (!on_tooth(here, within)) { off |= before; }
    if (!on_tooth(minus32(here, width), within)) { off |= after; }
    return off;
}

/* The slip that leaves fewer edges astray than none does. A single edge astray speaks for a slip only where a tooth
 * beside the mark is missing as well: without a slip that takes two faults. */
static int32_t find_slip(const sd_crank_t *self, const sd_vote_t *vote, int32_t width, uint32_t within) {
    if ((vote->astray == 0u) || ((vote->astray == 1u) && vote->left && vote->right)) { return 0; }
    uint32_t sums = 0, edges = 0;
    for (uint32_t i = 0; (i < SD_CRANK_WITNESSES) && (edges < 15u); ++i) { /* what four bits hold */
        int32_t here;
        if (!votes(self, i, width, BEFORE, &here)) { continue; }
        sums += astray_with(here, width, within);
        edges++;
    }
    int32_t found = 0;
    uint32_t least = vote->astray;
    for (int32_t slip = -SLIP_MAX; slip <= SLIP_MAX; ++slip, sums >>= 4) {
        if ((sums & 15u) < least) { least = sums & 15u; found = slip; }
    }
    return (least <= ASTRAY_MAX) ? found : 0;
}

static void angle_confirmed(sd_crank_t *self) {
    self->missed = 0;
    self->suspected_slip = 0;
    self->strain = 0;
    self->unsure = 0;
    self->provisional = 0;
}

static void put_right(sd_crank_t *self, int32_t slip) {
    const uint32_t before = self->position;
    self->position = (uint8_t)sd_wheel_step(self, before, -slip);
    if ((slip > 0) && (self->position > before)) { self->revolution ^= 1u; }
    if ((slip < 0) && (self->position < before)) { self->revolution ^= 1u; }
    self->counts.slips++;
    sd_memory_forget(self);
    angle_confirmed(self);
}

/* A mark lies behind the edge that comes now. */
void sd_mark_passed(sd_crank_t *self, uint32_t tick, const sd_crank_way_t *way, int32_t to_mark, uint32_t mark, bool clean) {
    self->pending_mark = (uint8_t)mark;
    self->mark_travel = (int32_t)((uint32_t)self->travel + (uint32_t)to_mark);
    /* The memory knows how long the mark takes, not how wide it is. */
    const sd_crank_clocks_t *clocks = &self->clocks[self->now];
    const uint32_t judge = sd_clock_best(clocks, MEMORY);
    const sd_forecast_t ahead = sd_clock_forecast(clocks, judge, way);
    const sd_inverse_t inverse = sd_inverse_of(ahead.period);
    self->mark_late = sd_in_spacings(&inverse, sd_clock_late(&clocks->clock[judge], tick, ahead.time));
    self->mark_clean = clean ? 1u : 0u;
    if (!sd_wheel_begins_pair(self, mark)) { return; }
    /* The second of the pair votes for both. */
    self->pending_mark = SD_CRANK_MARKS_MAX;
    if (clean && ((self->unsure | self->provisional) == 0u)) { sd_wheel_learn(self, mark, self->mark_late); }
}

void sd_mark_vote(sd_crank_t *self) {
    const uint32_t mark = self->pending_mark;
    /* Before the second of a pair there is one tooth, and then the first, which may be no whole number of spacings wide. A slip there
     * is not put right; marks missed end sync. */
    const bool pair = sd_wheel_has_pairs(self) && sd_wheel_ends_pair(self, mark);
    const sd_vote_t vote = count(self, self->mark_spacings[mark], pair ? ONE / 2 : BEFORE);
    const bool strained = self->strain > STRAINED;
    const bool loose = strained && (self->provisional == 0u);
    const uint32_t within = loose ? STRAY : (uint32_t)clamp_in(tight_gate(leading(self)->error), 0, (int32_t)STRAY);
    const int32_t slip = pair ? 0 : find_slip(self, &vote, self->mark_spacings[mark], within);
    self->pending_mark = SD_CRANK_MARKS_MAX;
    if (slip != 0) {
        /* Clocks that were never far off cannot have slipped: then it takes two marks to convince us. */
        const bool believed = strained || (slip == self->suspected_slip);
        self->suspected_slip = (int8_t)slip;
        if (believed) { put_right(self, slip); } else { self->unsure = 1; }
    } else if ((vote.inside > 0u) || (vote.astray > ASTRAY_MAX) || (vote.edges < VOTERS_MIN)) {
        self->counts.marks_missed++;
        self->missed = (uint8_t)(self->missed + 1u + self->unsure + 2u * self->provisional);
        if (pair) { self->unsure = 1; }
    } else if ((self->provisional == 0u) || (vote.left && vote.right)) {
        if (self->mark_clean != 0u) { sd_wheel_learn(self, mark, self->mark_late); }
        angle_confirmed(self);
    }
}
