/* SPDX-License-Identifier: MIT */
#include "sd_crank_parts.h"

enum {
    MISSED_MAX   = 4,  /* marks missed in a row that end sync */
    REJECTED_MAX = 20, /* edges left out, twice, minus teeth placed, that end sync */
    ODD_RUN      = 6,  /* even periods that overrule the clocks */
};

typedef struct sd_place {
    sd_crank_way_t way; /* from the last placed edge; 0 spacings: the last placed edge's own place */
    int32_t  late;      /* 1/64 tick, without what the mark's width may be blamed for */
    int32_t  period;    /* of a spacing there, 1/64 tick */
    int32_t  excused;   /* blamed on the mark's width, Q12 */
    int32_t  to_mark;   /* spacings to the tooth before that mark */
    uint32_t advance, coasted, position, slot, mark; /* mark: crossed on the way, or SD_CRANK_MARKS_MAX */
    bool     found;
} sd_place_t;

void sd_track_begin(sd_crank_t *self, uint32_t tick, uint32_t position) {
    self->position = (uint8_t)position;
    self->mode = SYNCED;
    self->revolution ^= 1u; /* two marks lie behind, and the revolution between them counts */
    self->counts.sync_gains++;
    self->missed = 0;
    self->rejected = 0;
    self->doubtful = 0;
    self->unsure = 0;
    self->provisional = 0;
    self->odd_periods = 0;
    self->suspected_slip = 0;
    self->strain = 0;
    self->pending_mark = SD_CRANK_MARKS_MAX;
    self->witness_next = 0;
    self->travel = 0;
    for (uint32_t i = 0; i < SD_CRANK_WITNESSES; ++i) { self->witness[i] = INT32_MIN; } /* no edge, and far from any mark */
    self->last_tick = tick;
}

/* The first tooth after a mark comes as its width says, give or take twice the scatter seen so far, but less than a
 * missing tooth would make. The memory needs no such excuse: it knows the time, not the width. */
static void excuse(const sd_crank_t *self, uint32_t mark, sd_place_t *place) {
    const int32_t most = clamp_in(2 * self->mark_scatter[mark], 0, (2 * ONE) / 3);
    const int32_t part = scale12(place->period, most);
    if (abs32(place->late) <= part) {
        const sd_inverse_t inverse = sd_inverse_of(place->period);
        place->excused = clamp_in(sd_in_spacings(&inverse, place->late), -ONE, ONE);
        place->late = 0;
    } else {
        place->excused = (place->late < 0) ? -most : most;
        place->late = minus32(place->late, (place->late < 0) ? -part : part);
    }
}

/* The place of the last placed edge, field by field: a zeroed struct would cost more than the rest. */
static inline void place_here(const sd_crank_t *self, sd_place_t *place) {
    place->way.spacings = place->way.last = 0;
    place->way.recalled = place->way.recalled_last = 0u;
    place->excused = place->to_mark = 0;
    place->advance = place->coasted = 0u;
    place->position = self->position;
    place->slot = self->slot;
    place->mark = SD_CRANK_MARKS_MAX;
    place->found = false;
}

/* Goes on to the next tooth, across `mark` if there is one. */
static inline void step_on(const sd_crank_t *self, sd_place_t *place, uint32_t mark) {
    int32_t spacings = ONE;
    if (mark < SD_CRANK_MARKS_MAX) {
        place->mark = mark;
        place->to_mark = place->way.spacings;
        spacings = self->mark_spacings[mark];
        place->position = sd_wheel_first_after(self, mark);
        place->advance += 1u + self->mark_run[mark];
    } else {
        place->position++;
        place->advance++;
    }
    place->slot = next_slot(self, place->slot);
    const uint32_t recalled = self->memory[place->slot];
    place->way.recalled = (place->way.recalled + recalled < recalled) ? UINT32_MAX : place->way.recalled + recalled;
    place->way.recalled_last = recalled;
    place->way.spacings += spacings;
    place->way.last = spacings;
}

/* The tooth position that `elapsed` comes nearest to. */
static void nearest_place(const sd_crank_t *self, int32_t elapsed, sd_place_t *best) {
    const sd_crank_clocks_t *clocks = &self->clocks[self->now];
    place_here(self, best);
    best->late = elapsed;
    best->period = clocks->clock[clocks->leader].period;
    sd_place_t next = *best;
    for (uint32_t step = 0; step <= SD_CRANK_COAST_MAX; ++step) {
        if (best->late < best->period / 4) { best->found = true; return; }
        const uint32_t mark = sd_wheel_mark_after(self, next.position);
        step_on(self, &next, mark);
        const sd_forecast_t ahead = sd_clock_forecast(clocks, clocks->leader, &next.way);
        next.coasted = step;
        next.period = ahead.period;
        next.late = minus32(elapsed, ahead.time);
        next.excused = 0;
        if ((mark < SD_CRANK_MARKS_MAX) && (clocks->leader != MEMORY)) { excuse(self, mark, &next); }
        if (abs32(next.late) > abs32(best->late)) { best->found = true; return; }
        *best = next;
    }
}

/* The usual edge: the next tooth, and no mark before it. Returns false where it is not. */
static inline bool next_place(const sd_crank_t *self, int32_t elapsed, sd_place_t *place) {
    if (sd_wheel_mark_after(self, self->position) < SD_CRANK_MARKS_MAX) { return false; }
    const uint32_t slot = next_slot(self, self->slot), recalled = self->memory[slot];
    const int32_t next = sd_clock_next(&self->clocks[self->now], recalled);
    const int32_t late = minus32(elapsed, next);
    if ((late >= next / 4) || (late <= -next / 4)) { return false; }
    place->way = (sd_crank_way_t){ ONE, ONE, recalled, recalled };
    place->slot = slot;
    place->period = next;
    place->late = late;
    place->excused = 0;
    place->advance = 1u;
    place->coasted = 0u;
    place->position = self->position + 1u;
    place->mark = SD_CRANK_MARKS_MAX;
    place->found = true;
    return true;
}

/* After missing teeth an edge far off is the less a tooth the better the clocks have been. */
static int32_t loose_gate(const sd_crank_t *self, const sd_place_t *place) {
    if (place->coasted == 0u) { return LOOSE; }
    return clamp_in(4 * leading(self)->error + ONE / 5, (35 * ONE) / 100, LOOSE);
}

static void remember(sd_crank_t *self, int32_t travel) {
    self->witness[self->witness_next] = travel;
    self->witness_next = (uint8_t)((self->witness_next + 1u) % SD_CRANK_WITNESSES);
}

static void move_clocks(sd_crank_t *self, uint32_t tick, bool clean, const sd_inverse_t *inverse) {
    if (self->placed_way.spacings == ONE) {
        sd_clocks_move(self, tick, clean, inverse);
    } else {
        sd_clocks_move_far(self, tick, clean, inverse);
    }
}

/* An early spurious edge may have taken the place of the tooth that comes now, fits better there, and better there than
 * at `place`, the next. */
static bool take_over(sd_crank_t *self, uint32_t tick, const sd_place_t *place, int32_t place_late) {
    if (self->placed_way.spacings < ONE) { return false; }
    sd_crank_clocks_t *before = &self->clocks[self->now ^ 1u];
    const sd_forecast_t ahead = sd_clock_forecast(before, before->leader, &self->placed_way);
    const sd_inverse_t inverse = sd_inverse_of(ahead.period);
    const int32_t late = sd_in_spacings(&inverse, sd_clock_late(&before->clock[before->leader], tick, ahead.time)) - self->placed_excused;
    const bool next = place->found && (place->advance > 0u) && (abs32(place_late) <= abs32(late));
    if (next || (abs32(late) >= abs32(self->placed_late))) { return false; }
    self->placed_late = late;
    move_clocks(self, tick, false, &inverse);
    return true;
}

static void leave_out(sd_crank_t *self, sd_tooth_t *tooth) {
    self->counts.spurious++;
    self->rejected = (uint8_t)(self->rejected + 2u);
    tooth->edge_class = SD_EDGE_SPURIOUS;
    tooth->why |= SD_WHY_FAULT;
}

/* Coasted so far or so badly that the next tooth may be another one. Errors grow on the way, but for memory and calm. */
static bool coasted_blindly(const sd_crank_clocks_t *clocks, const sd_place_t *place, int32_t late) {
    const int32_t far = (clocks->leader >= MEMORY) ? ONE : place->way.spacings;
    const int32_t blur = (clocks->clock[clocks->leader].error * (far >> 6)) >> 6;
    return (blur > (15 * ONE) / 100) || (abs32(late) > (35 * ONE) / 100);
}

/* What a longer way than one spacing brings with it, before the clocks move. */
static void go_far(sd_crank_t *self, uint32_t tick, const sd_place_t *place, int32_t late, bool clean) {
    if (place->mark < SD_CRANK_MARKS_MAX) { sd_mark_passed(self, tick, &place->way, place->to_mark, place->mark, clean); }
    if (place->coasted == 0u) { return; }
    if (coasted_blindly(&self->clocks[self->now], place, late)) { self->unsure = 1; }
    self->counts.coasted += place->coasted;
}

static void vote_if_due(sd_crank_t *self) {
    const int32_t since = (int32_t)((uint32_t)self->travel - (uint32_t)self->mark_travel);
    if (since >= self->mark_spacings[self->pending_mark] + VOTE_AFTER * ONE - ONE / 2) { sd_mark_vote(self); }
}

static void place_edge(sd_crank_t *self, uint32_t tick, const sd_place_t *place, int32_t late, bool clean, const sd_inverse_t *inverse,
                       sd_tooth_t *tooth) {
    const int32_t error = leading(self)->error, spacings = place->way.spacings;
    int32_t gate = tight_gate(error);
    tooth->period_ticks = tick - self->last_tick;
    tooth->span_spacings = (uint32_t)spacings;
    tooth->advance = (uint8_t)place->advance;
    tooth->edge_class = (place->coasted > 0u) ? SD_EDGE_COASTED : SD_EDGE_TOOTH;
    if (spacings != ONE) {
        gate = clamp_in((gate * (spacings >> 6)) >> 6, 0, LOOSE); /* grows with the way */
        go_far(self, tick, place, late, clean);
    }
    if (error > self->strain) { self->strain = error; }
    if (place->position < self->position) { self->revolution ^= 1u; }
    self->position = (uint8_t)place->position;
    self->slot = (uint8_t)place->slot;
    self->placed_way = place->way;
    self->placed_excused = place->excused;
    self->placed_late = late;
    self->now ^= 1u;
    move_clocks(self, tick, clean, inverse);
    if ((self->level_left | self->unlearned) != 0u) { sd_memory_fill(self, place->coasted + 1u, tooth->period_ticks); }
    self->travel = (int32_t)((uint32_t)self->travel + (uint32_t)spacings);
    self->doubtful = ((place->coasted > 0u) || (abs32(late) > gate)) ? 1u : 0u;
    if (self->rejected > 0u) { self->rejected--; }
    if ((self->pending_mark < SD_CRANK_MARKS_MAX) && (place->coasted == 0u)) { vote_if_due(self); }
}

static bool alike(uint32_t a, uint32_t b) { return (a - a / 5u <= b) && (b - b / 5u <= a); }

/* Even periods in a row are teeth, whatever the clocks believe: clocks that disagree with each have lost the rate. */
static bool rate_lost(sd_crank_t *self, uint32_t period) {
    const uint32_t believed = (uint32_t)leading(self)->period >> 6;
    const bool odd = !alike(period, believed) && alike(period, self->raw_period[0]);
    self->odd_periods = (uint8_t)(odd ? self->odd_periods + 1u : 0u);
    return self->odd_periods >= ODD_RUN;
}

static void reseat(sd_crank_t *self, uint32_t tick, uint32_t period) {
    const int32_t grown = ((int32_t)period - (int32_t)self->raw_period[0]) * 64;
    sd_clocks_start(self, tick, clamp32((int64_t)period << 6, PERIOD_MIN, PERIOD_MAX), grown);
    self->strain = ONE; /* the next vote may move the angle */
    self->unsure = 1;
    self->odd_periods = 0;
}

/* The memory may hold a fault of its own, and would then see a missing tooth and a spurious edge there in every
 * revolution. Where another clock finds the next tooth right on time, that clock leads. */
static void ask_another(sd_crank_t *self, uint32_t tick, sd_place_t *place) {
    sd_crank_clocks_t *clocks = &self->clocks[self->now];
    const uint32_t other = sd_clock_best(clocks, MEMORY);
    sd_place_t next;
    place_here(self, &next);
    next.found = true;
    step_on(self, &next, sd_wheel_mark_after(self, self->position));
    const sd_forecast_t ahead = sd_clock_forecast(clocks, other, &next.way);
    next.period = ahead.period;
    next.late = sd_clock_late(&clocks->clock[other], tick, ahead.time);
    if (abs32(next.late) > scale12(ahead.period, (12 * ONE) / 100)) { return; }
    clocks->leader = other;
    *place = next;
}

bool sd_track_edge(sd_crank_t *self, uint32_t tick, uint32_t raw_period, sd_tooth_t *tooth) {
    if (tick - self->last_tick > (uint32_t)(STALL_TICKS_MAX + STALL_TICKS_MAX / 2)) { return false; } /* times would not fit */
    const int32_t elapsed = sd_clock_since(leading(self), tick);
    sd_place_t place;
    const bool usual = next_place(self, elapsed, &place);
    if (!usual) {
        nearest_place(self, elapsed, &place);
        const bool next = (place.advance > 0u) && (place.coasted == 0u) && (abs32(place.late) <= scale12(place.period, LOOSE));
        if ((self->clocks[self->now].leader == MEMORY) && !next) { ask_another(self, tick, &place); }
    }
    const sd_inverse_t inverse = sd_inverse_of(place.period);
    const int32_t late = sd_in_spacings(&inverse, place.late);
    if (!usual && take_over(self, tick, &place, late)) {
        leave_out(self, tooth);
        return true;
    }
    if (!place.found) { return false; }
    remember(self, (int32_t)((uint32_t)self->travel + (uint32_t)place.way.spacings + (uint32_t)late));
    if ((place.way.spacings >= ONE) && (abs32(late) <= loose_gate(self, &place))) {
        const bool clean = (place.coasted == 0u) && (raw_period == tick - self->last_tick);
        place_edge(self, tick, &place, late, clean, &inverse, tooth);
    } else {
        leave_out(self, tooth);
    }
    if (usual && (self->doubtful == 0u)) {
        self->odd_periods = 0;
    } else if (rate_lost(self, raw_period)) {
        reseat(self, tick, raw_period);
    }
    return (self->rejected <= REJECTED_MAX) && (self->missed < MISSED_MAX);
}
