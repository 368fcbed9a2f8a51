/* SPDX-License-Identifier: MIT */
#include "sd_crank.h"

#include <string.h>

#define ONE SD_SPACING_ONE

enum { WAITING, SEARCHING, TRYING, SYNCED }; /* sd_crank_t.mode */

enum {
    STALL_TICKS_MAX = 1 << 24,
    SLIP_MAX        = 3,  /* teeth the vote at a mark can put right */
    VOTE_AFTER      = 3,  /* teeth past the mark before the vote */
    VOTERS_MIN      = 5,  /* edges that make a vote */
    ASTRAY_MAX      = 1,  /* edges astray that a vote may count as faults */
    STRAY           = (35 * ONE) / 100, /* an edge further from a tooth stands astray */
    MISSED_MAX      = 4,  /* marks missed in a row that end sync */
    REJECTED_MAX    = 20, /* edges left out, twice, less teeth placed, that end sync */
    ODD_RUN         = 6,  /* even periods that overrule the clocks */
    PHASE_VOTES     = 2,  /* cam edges that must agree */
    UNLEARNED       = ONE / 2,          /* scatter of a mark seen less than twice */
    TREND_LASTS     = 3 * ONE,          /* speed ripple turns round within a few teeth */
    LOOSE           = (42 * ONE) / 100, /* an edge further off is not this tooth */
    STRAINED        = (16 * ONE) / 100, /* clocks this far off, on average, may have slipped */
};

enum { QUICK, MIDDLE, MEMORY, CALM }; /* sd_crank_t.clock */

/* Steady gains of a fading-memory fit (Q12): share of an error given to time, period, change. What an edge weighs
 * shrinks by 0.2, 0.5, 0.5 and 0.85 a tooth. The fits are quadratic; that of the memory, which knows the bends, is
 * straight. */
typedef struct sd_gains { int32_t time, period, change; } sd_gains_t;
static const sd_gains_t GAINS[SD_CRANK_CLOCKS] = {
    { 4063, 4719, 2097 }, { 3584, 2304, 512 }, { 3072, 1024, 0 }, { 1581, 256, 14 }
};

/* ---- clocks ---------------------------------------------------------------------------------------------------- */

static int32_t abs32(int32_t x) { return (x < 0) ? -x : x; }
static int32_t clamp32(int64_t x, int32_t low, int32_t high) {
    return (x < low) ? low : (x > high) ? high : (int32_t)x;
}

static int64_t since_clock(const sd_crank_clock_t *c, uint32_t tick) {
    return ((int64_t)(int32_t)(tick - c->tick) * 64) - c->frac;
}

/* What a clock says of a way: how long it takes and the period at its end, 1/64 tick. */
typedef struct sd_forecast { int64_t time; int32_t period; } sd_forecast_t;

static sd_forecast_t forecast(const sd_crank_clock_t *c, uint32_t kind, const sd_crank_way_t *way) {
    int64_t time, period;
    if (kind == MEMORY) {
        time = ((int64_t)c->period * way->recalled) / way->period_from;
        period = ((int64_t)c->period * way->period_to) / way->period_from;
    } else {
        /* u (u + 1) / 2 while a trend can be trusted, then straight on. */
        const int64_t bent = (way->spacings > TREND_LASTS) ? TREND_LASTS : way->spacings;
        const int64_t bend = ((bent * (bent + ONE)) >> 13) + (((way->spacings - bent) * bent) >> 12);
        time = (((int64_t)c->period * way->spacings) >> 12) + (((int64_t)c->change * bend) >> 12);
        period = c->period + (((int64_t)c->change * bent) >> 12);
    }
    return (sd_forecast_t){ time, clamp32(period, c->period / 4, 4 * (c->period / 2)) };
}

/* How late `elapsed` is against a forecast, Q12 spacings. */
static int32_t lateness(const sd_forecast_t *ahead, int64_t elapsed) {
    return clamp32(((elapsed - ahead->time) * ONE) / ahead->period, -16 * ONE, 16 * ONE);
}

/* A quicker clock must beat a calmer one clearly: under jitter it does so by chance, and then follows the noise. The
 * memory must be beaten by more than a hair, because it alone knows what lies behind a missing tooth. */
static uint8_t best_clock(const sd_crank_t *self, uint32_t except) {
    uint32_t best = CALM;
    for (uint32_t i = CALM; i-- > 0u;) {
        if ((i != except) && (4 * self->clock[i].error + ONE / 100 < 3 * self->clock[best].error)) { best = i; }
    }
    return (uint8_t)best;
}

static void clock_start(sd_crank_clock_t *c, uint32_t tick, uint32_t period_ticks) {
    *c = (sd_crank_clock_t){ .tick = tick, .period = (int32_t)(period_ticks << 6), .error = ONE / 16 };
}

/* An edge that surprises the clock may be no tooth at all, so it moves the clock only as far as the clock's own
 * record of errors makes likely; the record grows with every surprise, so real changes get through in a few teeth. */
static int32_t clock_place(sd_crank_clock_t *c, uint32_t kind, uint32_t tick, const sd_crank_way_t *way) {
    const sd_gains_t *gain = &GAINS[kind];
    const sd_forecast_t ahead = forecast(c, kind, way);
    const int64_t elapsed = since_clock(c, tick);
    const int32_t error = abs32(lateness(&ahead, elapsed));
    const int32_t likely = ((4 * c->error + ONE / 20) * (way->spacings >> 6)) >> 6; /* errors grow with the way coasted */
    int64_t late = elapsed - ahead.time;
    if (error > likely) { late = (late * likely) / error; }
    const int64_t fitted = ahead.time + ((late * gain->time + ONE / 2) >> 12) + c->frac;
    const int64_t late_each = (late * ONE) / way->spacings;
    const int32_t period = ahead.period + (int32_t)((late_each * gain->period + ONE / 2) >> 12);
    const int64_t change = (kind == MEMORY) ? (((int64_t)ahead.period - c->period) * ONE) / way->spacings
                                            : c->change + (((late_each * ONE) / way->spacings * gain->change + ONE / 2) >> 12);
    c->tick += (uint32_t)(fitted >> 6);
    c->frac = (int32_t)(fitted & 63);
    c->period = clamp32(period, 64, STALL_TICKS_MAX << 6);
    c->change = clamp32(change, -c->period / 8, c->period / 8);
    c->error = clamp32(c->error + (error - c->error) / 16, 0, ONE / 2);
    return error;
}

/* ---- the wheel ------------------------------------------------------------------------------------------------- */

static bool is_missing(const sd_crank_config_t *config, uint32_t position) {
    for (uint32_t i = 0; i < config->missing_count; ++i) {
        if (config->missing[i] == position) { return true; }
    }
    return false;
}

/* The mark that begins right after `position`, or SD_CRANK_MARKS_MAX. */
static uint32_t mark_after(const sd_crank_t *self, uint32_t position) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        if (self->mark_first[m] == position + 1u) { return m; }
    }
    return SD_CRANK_MARKS_MAX;
}

static uint32_t first_tooth_after(const sd_crank_t *self, uint32_t mark) {
    return ((uint32_t)self->mark_first[mark] + self->mark_run[mark]) % self->config.positions;
}

static bool second_after_a_mark(const sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        if (self->position == first_tooth_after(self, m) + 1u) { return true; }
    }
    return false;
}

static void sum_turn(sd_crank_t *self) {
    self->turn_spacings = (self->config.positions - self->config.missing_count - self->mark_count) * ONE;
    for (uint32_t m = 0; m < self->mark_count; ++m) { self->turn_spacings += self->mark_spacings[m]; }
}

static void reset_widths(sd_crank_t *self) {
    for (uint32_t m = 0; m < self->mark_count; ++m) {
        self->mark_spacings[m] = (self->mark_run[m] + 1) * ONE;
        self->mark_scatter[m] = UNLEARNED;
    }
    sum_turn(self);
}

/* 1.6 to 4.5 spacings is what real sensors make of a mark of any width. */
static int32_t plausible_width(int64_t spacings) { return clamp32(spacings, (16 * ONE) / 10, (45 * ONE) / 10); }

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
        const uint32_t teeth = (next + self->config.positions - first_tooth_after(self, m)) % self->config.positions;
        if (teeth < 4u) { return false; }
    }
    return true;
}

sd_result_t sd_crank_init(sd_crank_t *self, const sd_crank_config_t *config) {
    sd_crank_t fresh;
    memset(&fresh, 0, sizeof fresh);
    fresh.config = *config;
    fresh.pending_mark = SD_CRANK_MARKS_MAX;
    const bool in_range = (config->positions >= SD_CRANK_POSITIONS_MIN) && (config->positions <= SD_CRANK_POSITIONS_MAX) &&
                          (config->missing_count >= 1u) && (config->missing_count <= SD_CRANK_MISSING_MAX) &&
                          (config->stall_ticks >= 256u) && (config->stall_ticks <= (uint32_t)STALL_TICKS_MAX) &&
                          (config->cam_position < 2u * config->positions);
    if (!in_range) { return SD_ERR_CONFIG; }
    for (uint32_t i = 1; i < config->missing_count; ++i) {
        if (config->missing[i] <= config->missing[i - 1u]) { return SD_ERR_CONFIG; }
    }
    if (config->missing[config->missing_count - 1u] != config->positions - 1u) { return SD_ERR_CONFIG; }
    if (!collect_marks(&fresh) || !marks_stand_apart(&fresh)) { return SD_ERR_CONFIG; }
    reset_widths(&fresh);
    *self = fresh;
    return SD_OK;
}

/* ---- losing and finding sync ----------------------------------------------------------------------------------- */

static void forget_angle(sd_crank_t *self, uint8_t mode) {
    if (self->mode == SYNCED) { self->counts.sync_losses++; }
    self->mode = mode;
    self->phase_votes = 0;
    self->pending_mark = SD_CRANK_MARKS_MAX;
    self->raw_period[0] = self->raw_period[1] = 0;
    reset_widths(self);
}

/* The period before this edge stands out against its neighbours as a mark does. */
static bool gap_seen(const sd_crank_t *self, uint32_t period) {
    const uint64_t before = self->raw_period[1], gap = self->raw_period[0], after = period;
    const uint64_t sides = before + after;
    return (before != 0u) && (before <= 2u * after) && (after <= 2u * before) && (4u * gap >= 3u * sides) &&
           (20u * gap <= 46u * sides);
}

/* The angle moved, so what is remembered belongs to other teeth. */
static void forget_turn(sd_crank_t *self) { memset(self->memory, 0, sizeof self->memory); }

static void start_clocks(sd_crank_t *self, uint32_t tick, uint32_t period) {
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; ++i) { clock_start(&self->clock[i], tick, period); }
    const uint32_t recalled = self->memory[self->position];
    self->memory_period = (int32_t)((recalled > 0u) ? recalled : period << 6);
}

/* Takes the gap just seen for mark try_mark: this edge is the second tooth after it. */
static void begin_try(sd_crank_t *self, uint32_t tick, uint32_t period) {
    const uint32_t mark = self->try_mark;
    self->mode = TRYING;
    self->confirmed = 0;
    self->missed = 0;
    self->rejected = 0;
    self->doubtful = 0;
    self->unsure = 0;
    self->odd_periods = 0;
    self->placed_way.spacings = 0;
    self->leader = 0;
    self->pending_mark = SD_CRANK_MARKS_MAX;
    self->position = (uint8_t)(first_tooth_after(self, mark) + 1u);
    self->witness_count = 0;
    forget_turn(self);
    const uint64_t sides = (uint64_t)self->raw_period[1] + period;
    reset_widths(self);
    self->mark_spacings[mark] = plausible_width((int64_t)((2u * ONE * (uint64_t)self->raw_period[0]) / sides));
    sum_turn(self);
    start_clocks(self, tick, period);
    self->last_tick = tick;
}

static void try_failed(sd_crank_t *self) {
    self->try_mark = (uint8_t)((self->try_mark + 1u) % self->mark_count);
    forget_angle(self, SEARCHING);
}

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
    self->mark_spacings[mark] = plausible_width(self->mark_spacings[mark] + stray / (first ? 2 : 8));
    sum_turn(self);
}

static void vote(sd_crank_t *self) {
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
        forget_turn(self);
        angle_confirmed(self);
    } else if ((here.inside > 0) || (here.astray > ASTRAY_MAX) || (here.edges < VOTERS_MIN)) {
        self->counts.marks_missed++;
        self->missed = (uint8_t)(self->missed + 1u + self->unsure);
    } else {
        learn_mark(self, mark);
        angle_confirmed(self);
    }
}

/* ---- placing edges --------------------------------------------------------------------------------------------- */

typedef struct sd_place {
    sd_crank_way_t way; /* from the last placed edge; 0 spacings: the last placed edge's own place */
    int32_t  late;      /* Q12 spacings, less what the mark's width may be blamed for */
    int32_t  excused;   /* that part */
    uint32_t advance, coasted, position, mark; /* mark: crossed on the way, or SD_CRANK_MARKS_MAX */
    int32_t  to_mark;   /* spacings to the tooth before that mark */
    bool     found;
} sd_place_t;

/* The first tooth after a mark comes as its width says, give or take twice the scatter seen so far. The memory needs
 * no such excuse: it knows the time, not the width. */
static int32_t excuse(const sd_crank_t *self, uint32_t mark, int32_t late) {
    return clamp32(late, -2 * self->mark_scatter[mark], 2 * self->mark_scatter[mark]);
}

/* Goes on to the next tooth. Where nothing is remembered, the memory goes on as it went before. */
static void lengthen(const sd_crank_t *self, sd_crank_way_t *way, uint32_t position, int32_t spacings) {
    const uint32_t recalled = self->memory[position];
    if (recalled > 0u) { way->period_to = clamp32(((int64_t)recalled * ONE) / spacings, 64, STALL_TICKS_MAX << 6); }
    way->recalled += ((int64_t)way->period_to * spacings) >> 12;
    way->spacings += spacings;
}

/* The tooth position that `elapsed` comes nearest to. */
static sd_place_t nearest_place(const sd_crank_t *self, int64_t elapsed) {
    const sd_crank_clock_t *clock = &self->clock[self->leader];
    sd_place_t best = { .position = self->position, .mark = SD_CRANK_MARKS_MAX };
    best.way.period_from = best.way.period_to = self->memory_period;
    sd_forecast_t ahead = forecast(clock, self->leader, &best.way);
    best.late = lateness(&ahead, elapsed);
    sd_place_t next = best;
    for (uint32_t step = 0; step <= SD_CRANK_COAST_MAX; ++step) {
        if (best.late < ONE / 4) { best.found = true; return best; }
        const uint32_t mark = mark_after(self, next.position);
        const uint32_t run = (mark < SD_CRANK_MARKS_MAX) ? self->mark_run[mark] : 0u;
        if (run > 0u) { next.mark = mark; next.to_mark = next.way.spacings; }
        next.position = (next.position + 1u + run) % self->config.positions;
        next.advance += 1u + run;
        next.coasted = step;
        lengthen(self, &next.way, next.position, (run > 0u) ? self->mark_spacings[mark] : ONE);
        ahead = forecast(clock, self->leader, &next.way);
        next.late = lateness(&ahead, elapsed);
        next.excused = ((run > 0u) && (self->leader != MEMORY)) ? excuse(self, mark, next.late) : 0;
        next.late -= next.excused;
        if (abs32(next.late) > abs32(best.late)) { best.found = true; return best; }
        best = next;
    }
    return best;
}

/* Edges further off than this are flagged; further off than LOOSE they are left out. */
static int32_t tight_gate(const sd_crank_clock_t *clock) {
    return clamp32(4 * (int64_t)clock->error + (6 * ONE) / 100, (12 * ONE) / 100, LOOSE);
}

/* A quarter of the news each revolution: jitter averages out, a change of speed gets in. */
static void remember_time(sd_crank_t *self, uint32_t position, uint32_t period_ticks) {
    const int32_t known = (int32_t)self->memory[position], news = (int32_t)(period_ticks << 6);
    self->memory[position] = (uint32_t)((known == 0) ? news : known + (news - known) / 4);
}

static void remember(sd_crank_t *self, int32_t travel) {
    self->witness[self->witness_next] = travel;
    self->witness_next = (uint8_t)((self->witness_next + 1u) % SD_CRANK_WITNESSES);
    if (self->witness_count < SD_CRANK_WITNESSES) { self->witness_count++; }
}

/* What a mark's width is blamed for moves only the calm clock's idea of the way, not of the time: the quick ones are
 * there for ripple, and need the news that a mark's long period brings. */
static void move_clocks(sd_crank_t *self, uint32_t tick, bool clean) {
    sd_crank_clock_t *memory = &self->clock[MEMORY];
    int32_t error[SD_CRANK_CLOCKS];
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; ++i) {
        sd_crank_way_t way = self->placed_way;
        if (i == CALM) { way.spacings += self->placed_excused; }
        self->clock[i] = self->before[i];
        error[i] = clock_place(&self->clock[i], i, tick, &way);
    }
    /* What surprises the memory more than the quick clock is no fault: a cylinder fires, and the memory is history. */
    if (clean && (error[MEMORY] > error[QUICK] + ONE / 20)) {
        memory->error = clamp32(memory->error + (error[MEMORY] - memory->error) / 2, 0, ONE / 2);
    }
    self->leader = best_clock(self, SD_CRANK_CLOCKS);
    self->last_tick = tick;
}

/* An early spurious edge may have taken the place of the tooth that comes now, fits better there, and better there than
 * at `place`, the next. */
static bool take_over(sd_crank_t *self, uint32_t tick, const sd_place_t *place) {
    if (self->placed_way.spacings == 0) { return false; }
    const sd_crank_clock_t *before = &self->before[self->before_leader];
    const sd_forecast_t ahead = forecast(before, self->before_leader, &self->placed_way);
    const int32_t late = lateness(&ahead, since_clock(before, tick)) - self->placed_excused;
    const bool next = place->found && (place->advance > 0u) && (abs32(place->late) <= abs32(late));
    if (next || (abs32(late) >= abs32(self->placed_late))) { return false; }
    self->leader = self->before_leader;
    self->placed_late = late;
    move_clocks(self, tick, false);
    return true;
}

static void leave_out(sd_crank_t *self, sd_tooth_t *tooth) {
    self->counts.spurious++;
    self->rejected = (uint8_t)(self->rejected + 2u);
    tooth->edge_class = (self->mode == SYNCED) ? SD_EDGE_SPURIOUS : SD_EDGE_UNSYNCED;
    tooth->why |= SD_WHY_FAULT;
}

static void pass_mark(sd_crank_t *self, uint32_t tick, const sd_place_t *place, bool clean) {
    if (place->mark == SD_CRANK_MARKS_MAX) { return; }
    self->pending_mark = (uint8_t)place->mark;
    self->mark_travel = (int32_t)((uint32_t)self->travel + (uint32_t)place->to_mark);
    /* The memory knows how long the mark takes, not how wide it is. */
    const uint32_t judge = best_clock(self, MEMORY);
    const sd_forecast_t ahead = forecast(&self->clock[judge], judge, &place->way);
    self->mark_late = lateness(&ahead, since_clock(&self->clock[judge], tick));
    self->mark_clean = clean ? 1u : 0u;
    if (self->mode != TRYING) { return; }
    /* The mark that gives sync must stand out by itself, not only fit what a try expects. */
    const uint64_t period = tick - self->last_tick;
    if (!clean || (2u * period < 3u * (uint64_t)self->raw_period[0])) { try_failed(self); return; }
    if (++self->confirmed >= self->mark_count) {
        self->mode = SYNCED;
        self->counts.sync_gains++;
    }
}

/* Coasted so far or so badly that the next tooth may be another one. Errors grow on the way, but for memory and calm. */
static bool coasted_blindly(const sd_crank_t *self, const sd_place_t *place) {
    const int32_t far = (self->leader >= MEMORY) ? ONE : place->way.spacings;
    const int32_t blur = (self->clock[self->leader].error * (far >> 6)) >> 6;
    return (blur > (15 * ONE) / 100) || (abs32(place->late) > (35 * ONE) / 100);
}

static void place_edge(sd_crank_t *self, uint32_t tick, const sd_place_t *place, bool clean, sd_tooth_t *tooth) {
    const int32_t far = place->way.spacings >> 6; /* errors grow with the way since the last tooth */
    const bool tight = abs32(place->late) <= clamp32(((int64_t)tight_gate(&self->clock[self->leader]) * far) >> 6, 0, LOOSE);
    tooth->period_ticks = tick - self->last_tick;
    tooth->span_spacings = (uint32_t)place->way.spacings;
    tooth->advance = (uint8_t)place->advance;
    if (place->position < self->position) { self->revolution ^= 1u; }
    pass_mark(self, tick, place, clean);
    if (self->mode < TRYING) { return; }
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; ++i) { self->before[i] = self->clock[i]; }
    if ((place->coasted > 0u) && coasted_blindly(self, place)) { self->unsure = 1; }
    if ((self->mode == TRYING) && (self->unsure != 0u)) { try_failed(self); return; }
    if (self->clock[self->leader].error > self->strain) { self->strain = self->clock[self->leader].error; }
    self->before_leader = self->leader;
    self->placed_way = place->way;
    self->memory_period = place->way.period_to;
    self->placed_excused = place->excused;
    self->placed_late = place->late;
    move_clocks(self, tick, clean);
    self->travel = (int32_t)((uint32_t)self->travel + (uint32_t)place->way.spacings);
    self->position = (uint8_t)place->position;
    self->counts.coasted += place->coasted;
    if (clean && tight) { remember_time(self, place->position, tooth->period_ticks); }
    self->doubtful = ((place->coasted > 0u) || !tight) ? 1u : 0u;
    if (self->rejected > 0u) { self->rejected--; }
    if ((self->pending_mark < SD_CRANK_MARKS_MAX) && (self->mode == SYNCED) &&
        ((int32_t)((uint32_t)self->travel - (uint32_t)self->mark_travel) >=
         self->mark_spacings[self->pending_mark] + VOTE_AFTER * ONE - ONE / 2)) {
        vote(self);
    }
    tooth->edge_class = (place->coasted > 0u) ? SD_EDGE_COASTED : SD_EDGE_TOOTH;
}

static bool alike(uint64_t a, uint64_t b) { return (4u * a <= 5u * b) && (4u * b <= 5u * a); }

/* Even periods in a row are teeth, whatever the clocks believe: clocks that disagree with each have lost the rate. */
static bool rate_lost(sd_crank_t *self, uint32_t period) {
    const uint64_t believed = (uint64_t)self->clock[self->leader].period;
    const bool odd = alike(period, self->raw_period[0]) && !alike((uint64_t)period * 64u, believed);
    self->odd_periods = (uint8_t)(odd ? self->odd_periods + 1u : 0u);
    return self->odd_periods >= ODD_RUN;
}

static void reseat(sd_crank_t *self, uint32_t tick, uint32_t period) {
    start_clocks(self, tick, period);
    self->clock[0].change = ((int32_t)period - (int32_t)self->raw_period[0]) * 64;
    self->leader = 0;
    self->strain = ONE; /* the next vote may move the angle */
    self->unsure = 1;
    self->odd_periods = 0;
    self->placed_way.spacings = 0;
}

static void track(sd_crank_t *self, uint32_t tick, uint32_t raw_period, sd_tooth_t *tooth) {
    const sd_crank_clock_t *lead = &self->clock[self->leader];
    const sd_place_t place = nearest_place(self, since_clock(lead, tick));
    if (take_over(self, tick, &place)) {
        leave_out(self, tooth);
        return;
    }
    if (!place.found) {
        forget_angle(self, SEARCHING);
        return;
    }
    remember(self, (int32_t)((uint32_t)self->travel + (uint32_t)place.way.spacings + (uint32_t)place.late));
    const bool fits = (place.advance > 0u) && (abs32(place.late) <= LOOSE);
    if (fits) {
        const bool clean = (place.coasted == 0u) && (raw_period == tick - self->last_tick);
        place_edge(self, tick, &place, clean, tooth);
    } else {
        leave_out(self, tooth);
    }
    if (rate_lost(self, raw_period)) { reseat(self, tick, raw_period); }
    if ((self->rejected > REJECTED_MAX) || (self->missed >= MISSED_MAX)) { forget_angle(self, SEARCHING); }
}

static void describe(const sd_crank_t *self, sd_tooth_t *tooth) {
    tooth->position = self->position;
    tooth->change_ticks_q6 = self->clock[self->leader].change;
    tooth->phase_known = (self->phase_votes >= PHASE_VOTES) ? 1u : 0u;
    tooth->cycle_position = (uint16_t)(self->position + self->revolution * self->config.positions);
    if (self->mode != SYNCED) {
        tooth->edge_class = SD_EDGE_UNSYNCED;
        tooth->health = SD_INVALID;
        tooth->why |= SD_WHY_NO_SYNC;
    } else if (tooth->edge_class == SD_EDGE_SPURIOUS) {
        tooth->health = SD_INVALID;
    } else if ((self->doubtful | self->unsure) != 0u) {
        tooth->health = SD_DEGRADED;
        tooth->why |= SD_WHY_FAULT;
    } else {
        tooth->health = SD_VALID;
    }
}

void sd_crank_edge(sd_crank_t *self, uint32_t tick, sd_tooth_t *tooth) {
    *tooth = (sd_tooth_t){ .tick = tick, .edge_class = SD_EDGE_UNSYNCED };
    self->counts.edges++;
    sd_crank_poll(self, tick);
    const uint32_t raw_period = tick - self->raw_tick;
    if (self->mode == WAITING) {
        self->mode = SEARCHING;
    } else {
        if (self->mode >= TRYING) { track(self, tick, raw_period, tooth); }
        const bool gap = gap_seen(self, raw_period);
        const bool expected = (self->mode == TRYING) && (tooth->advance > 0u) && second_after_a_mark(self);
        if ((self->mode <= TRYING) && gap && !expected) { begin_try(self, tick, raw_period); }
        self->raw_period[1] = self->raw_period[0];
        self->raw_period[0] = raw_period;
    }
    self->raw_tick = tick;
    describe(self, tooth);
}

void sd_crank_edges(sd_crank_t *self, const uint32_t *ticks, uint32_t count, sd_tooth_t *teeth) {
    for (uint32_t i = 0; i < count; ++i) { sd_crank_edge(self, ticks[i], &teeth[i]); }
}

/* ---- phase, time, speed ---------------------------------------------------------------------------------------- */

void sd_crank_cam_edge(sd_crank_t *self, uint32_t tick) {
    const uint32_t n = self->config.positions;
    if ((self->mode != SYNCED) || (self->config.has_cam == 0u)) { self->counts.cam_rejected++; return; }
    const sd_crank_clock_t *lead = &self->clock[self->leader];
    const int64_t ahead = (since_clock(lead, tick) * 2) / lead->period; /* half positions since the last placed edge */
    const uint32_t here = (uint32_t)(self->position + (ahead + 1) / 2) % n;
    const uint32_t off = (here + n - self->config.cam_position % n) % n;
    if ((off > n / 8u) && (off < n - n / 8u)) { self->counts.cam_rejected++; return; }
    /* An edge a little off may stand in the revolution before or after the one cam_position lies in. */
    const uint32_t crossed = (self->position > here) ? 1u : 0u;
    const uint32_t target = (self->config.cam_position + ((off <= n / 8u) ? off : 2u * n + off - n)) % (2u * n);
    const uint8_t revolution = (uint8_t)((target / n + crossed) & 1u);
    if (revolution == self->revolution) {
        if (self->phase_votes < PHASE_VOTES) { self->phase_votes++; }
    } else {
        self->counts.cam_rejected += (self->phase_votes > 0u) ? 1u : 0u;
        self->revolution = revolution;
        self->phase_votes = 1;
    }
}

bool sd_crank_poll(sd_crank_t *self, uint32_t tick) {
    if ((self->mode == WAITING) || (tick - self->raw_tick <= self->config.stall_ticks)) { return false; }
    forget_angle(self, WAITING);
    self->counts.stalls++;
    return true;
}

float sd_crank_speed_radps(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz) {
    if (tooth->period_ticks == 0u) { return 0.0f; }
    const float turns = (float)tooth->span_spacings / (float)self->turn_spacings;
    return 6.2831853f * turns * tick_hz / (float)tooth->period_ticks;
}

float sd_crank_acceleration_radps2(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz) {
    const float speed_radps = sd_crank_speed_radps(self, tooth, tick_hz);
    const sd_crank_clock_t *lead = &self->clock[self->leader];
    if ((speed_radps <= 0.0f) || (lead->period <= 0)) { return 0.0f; }
    const float period_s = (float)lead->period / (64.0f * tick_hz);
    return -speed_radps * ((float)lead->change / (float)lead->period) / period_s;
}
