/* SPDX-License-Identifier: MIT */
#include "sd_crank.h"

#include <string.h>

#include "sd_crank_parts.h"

enum {
    MISSED_MAX      = 4,  /* marks missed in a row that end sync */
    REJECTED_MAX    = 20, /* edges left out, twice, less teeth placed, that end sync */
    ODD_RUN         = 6,  /* even periods that overrule the clocks */
    PHASE_VOTES     = 2,  /* cam edges that must agree */
    LOOSE           = (42 * ONE) / 100, /* an edge further off is not this tooth */
};

_Static_assert(sizeof(sd_crank_t) == 904, "without pointers, the same size on every target");

static bool stall_in_range(uint32_t ticks) { return (ticks >= 256u) && (ticks <= (uint32_t)STALL_TICKS_MAX); }

sd_result_t sd_crank_init(sd_crank_t *self, const sd_crank_config_t *config) {
    sd_crank_t fresh;
    memset(&fresh, 0, sizeof fresh);
    fresh.config = *config;
    fresh.pending_mark = SD_CRANK_MARKS_MAX;
    const bool in_range = (config->positions >= SD_CRANK_POSITIONS_MIN) && (config->positions <= SD_CRANK_POSITIONS_MAX) &&
                          (config->missing_count >= 1u) && (config->missing_count <= SD_CRANK_MISSING_MAX) &&
                          stall_in_range(config->stall_ticks) &&
                          (config->cam_position < 2u * config->positions);
    if (!in_range) { return SD_ERR_CONFIG; }
    for (uint32_t i = 1; i < config->missing_count; ++i) {
        if (config->missing[i] <= config->missing[i - 1u]) { return SD_ERR_CONFIG; }
    }
    if (config->missing[config->missing_count - 1u] != config->positions - 1u) { return SD_ERR_CONFIG; }
    if (!sd_wheel_find_marks(&fresh)) { return SD_ERR_CONFIG; }
    sd_wheel_reset_widths(&fresh);
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
    sd_wheel_reset_widths(self);
}

/* The period before this edge stands out against its neighbours as a mark does. */
static bool gap_seen(const sd_crank_t *self, uint32_t period) {
    const uint64_t before = self->raw_period[1], gap = self->raw_period[0], after = period;
    const uint64_t sides = before + after;
    return (before != 0u) && (before <= 2u * after) && (after <= 2u * before) && (4u * gap >= 3u * sides) &&
           (20u * gap <= 46u * sides);
}

static void start_clocks(sd_crank_t *self, uint32_t tick, uint32_t period) {
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; ++i) { sd_clock_start(&self->clock[i], tick, period); }
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
    self->position = (uint8_t)(sd_wheel_first_after(self, mark) + 1u);
    self->witness_count = 0;
    sd_memory_forget(self);
    const uint64_t sides = (uint64_t)self->raw_period[1] + period;
    sd_wheel_reset_widths(self);
    self->mark_spacings[mark] = sd_wheel_plausible_width((int64_t)((2u * ONE * (uint64_t)self->raw_period[0]) / sides));
    sd_wheel_sum_turn(self);
    start_clocks(self, tick, period);
    self->last_tick = tick;
}

static void try_failed(sd_crank_t *self) {
    self->try_mark = (uint8_t)((self->try_mark + 1u) % self->mark_count);
    forget_angle(self, SEARCHING);
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
    sd_forecast_t ahead = sd_clock_forecast(clock, self->leader, &best.way);
    best.late = sd_clock_lateness(&ahead, elapsed);
    sd_place_t next = best;
    for (uint32_t step = 0; step <= SD_CRANK_COAST_MAX; ++step) {
        if (best.late < ONE / 4) { best.found = true; return best; }
        const uint32_t mark = sd_wheel_mark_after(self, next.position);
        const uint32_t run = (mark < SD_CRANK_MARKS_MAX) ? self->mark_run[mark] : 0u;
        if (run > 0u) { next.mark = mark; next.to_mark = next.way.spacings; }
        next.position = (next.position + 1u + run) % self->config.positions;
        next.advance += 1u + run;
        next.coasted = step;
        lengthen(self, &next.way, next.position, (run > 0u) ? self->mark_spacings[mark] : ONE);
        ahead = sd_clock_forecast(clock, self->leader, &next.way);
        next.late = sd_clock_lateness(&ahead, elapsed);
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
        error[i] = sd_clock_place(&self->clock[i], i, tick, &way);
    }
    /* What surprises the memory more than the quick clock is no fault: a cylinder fires, and the memory is history. */
    if (clean && (error[MEMORY] > error[QUICK] + ONE / 20)) {
        memory->error = clamp32(memory->error + (error[MEMORY] - memory->error) / 2, 0, ONE / 2);
    }
    self->leader = sd_clock_best(self, SD_CRANK_CLOCKS);
    self->last_tick = tick;
}

/* An early spurious edge may have taken the place of the tooth that comes now, fits better there, and better there than
 * at `place`, the next. */
static bool take_over(sd_crank_t *self, uint32_t tick, const sd_place_t *place) {
    if (self->placed_way.spacings == 0) { return false; }
    const sd_crank_clock_t *before = &self->before[self->before_leader];
    const sd_forecast_t ahead = sd_clock_forecast(before, self->before_leader, &self->placed_way);
    const int32_t late = sd_clock_lateness(&ahead, sd_clock_since(before, tick)) - self->placed_excused;
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
    const uint32_t judge = sd_clock_best(self, MEMORY);
    const sd_forecast_t ahead = sd_clock_forecast(&self->clock[judge], judge, &place->way);
    self->mark_late = sd_clock_lateness(&ahead, sd_clock_since(&self->clock[judge], tick));
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
        sd_mark_vote(self);
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
    const sd_place_t place = nearest_place(self, sd_clock_since(lead, tick));
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
        const bool expected = (self->mode == TRYING) && (tooth->advance > 0u) && sd_wheel_second_after(self);
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
    const int64_t ahead = (sd_clock_since(lead, tick) * 2) / lead->period; /* half positions since the last placed edge */
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

void sd_crank_lose_sync(sd_crank_t *self) { forget_angle(self, WAITING); }

sd_result_t sd_crank_set_stall(sd_crank_t *self, uint32_t stall_ticks) {
    if (!stall_in_range(stall_ticks)) { return SD_ERR_CONFIG; }
    self->config.stall_ticks = stall_ticks;
    return SD_OK;
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
