/* SPDX-License-Identifier: MIT */
#include "sd_crank_parts.h"

/* How clocks and memory begin, and how the memory is filled. */

enum {
    LEVEL_FIRST = 8,  /* intervals told in present time at sync; the calm clock's first period is their mean */
    LEVEL_EACH  = 3,  /* and at each tooth after it */
};

/* `period` now over the remembered `recalled`, Q16. */
static uint32_t ratio_of(uint32_t recalled, int32_t period) {
    const sd_inverse_t inverse = sd_inverse_of(clamp32(recalled, PERIOD_MIN, PERIOD_MAX));
    return (uint32_t)clamp_in(sd_in_spacings(&inverse, period) * 16, RATIO_MIN, RATIO_MAX);
}

/* From the last intervals alone: the quick clock leads. */
void sd_clocks_start(sd_crank_t *self, uint32_t tick, int32_t period, int32_t change) {
    sd_crank_clocks_t *clocks = clocks_now(self);
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; ++i) {
        clocks->clock[i] = (sd_crank_clock_t){ .time = tick << 6, .period = period, .error = ONE / 8 };
    }
    clocks->clock[QUICK].change = clamp_in(change, -(period >> 3), period >> 3);
    clocks->clock[QUICK].error = ONE / 32;
    clocks->leader = QUICK;
    clocks->ratio = (self->unlearned == 0u) ? ratio_of(self->memory[self->slot], period) : 1u << 16;
    self->placed_way.spacings = 0;
    self->last_tick = tick;
}

/* ---- at sync, from a whole revolution of intervals -------------------------------------------------------------- */

/* Tells the next remembered intervals in present time: what came first is a revolution old, what came last is new. */
static void level(sd_crank_t *self, uint32_t count) {
    for (; (count > 0u) && (self->level_left > 0u); --count) {
        self->memory[self->level_slot] = (uint32_t)(((uint64_t)self->memory[self->level_slot] * (uint32_t)self->level) >> 20);
        self->level = (int32_t)((uint32_t)self->level - (uint32_t)self->level_step);
        self->level_slot = (uint8_t)next_slot(self, self->level_slot);
        self->level_left--;
    }
}

static void begin_level(sd_crank_t *self) {
    const sd_inverse_t inverse = sd_inverse_of(clamp32(self->grown_before, PERIOD_MIN, PERIOD_MAX));
    self->level = sd_in_spacings(&inverse, clamp32(self->grown_now, 0, PERIOD_MAX)) * 256; /* change over the revolution, Q20 */
    self->level_step = (self->level - (ONE << 8)) / self->teeth;
    self->level_left = self->teeth;
    self->level_slot = (uint8_t)next_slot(self, self->slot);
    level(self, LEVEL_FIRST);
}

/* Teeth from here to the next mark. */
static uint32_t teeth_to_mark(const sd_crank_t *self, uint32_t *mark) {
    uint32_t m = 0;
    while ((m + 1u < self->mark_count) && (self->mark_first[m] <= self->position)) { m++; } /* the last position of a wheel is missing */
    *mark = m;
    return self->mark_first[m] - self->position - 1u;
}

/* Means of the next two and of the next eight intervals, marks left out. */
static void means_ahead(const sd_crank_t *self, int32_t *two, int32_t *eight) {
    uint32_t mark, clear = teeth_to_mark(self, &mark), slot = self->slot, sum = 0, first_two = 0;
    for (uint32_t taken = 1; taken <= LEVEL_FIRST; ++taken) {
        slot = next_slot(self, slot);
        while (clear == 0u) { /* the interval across the mark, or two of them */
            clear = sd_wheel_teeth_after(self, mark) - 1u;
            mark = (mark + 1u < self->mark_count) ? mark + 1u : 0u;
            slot = next_slot(self, slot);
        }
        clear--;
        sum += self->memory[slot] >> 3; /* so that eight fit */
        if (taken == 2u) { first_two = sum; }
    }
    *two = clamp32((int64_t)first_two << 2, PERIOD_MIN, PERIOD_MAX);
    *eight = clamp32(sum, PERIOD_MIN, PERIOD_MAX);
}

/* Where edges are quiet the memory leads; else whichever the noise disturbs less, which is the calm clock where speed is
 * even. */
void sd_clocks_recall(sd_crank_t *self, uint32_t tick, uint32_t noise_q12, uint32_t uneven_q12) {
    sd_crank_clocks_t *clocks = clocks_now(self);
    const int32_t noise = clamp32(noise_q12, ONE / 64, ONE / 4);
    int32_t two, eight;
    begin_level(self);
    means_ahead(self, &two, &eight);
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; ++i) {
        clocks->clock[i] = (sd_crank_clock_t){ .time = tick << 6, .period = (i == CALM) ? eight : two, .error = ONE / 8 };
    }
    clocks->clock[MEMORY].error = noise;
    if (noise >= NOISY) {
        const int32_t ripple = clamp32((int64_t)uneven_q12 - (noise * 4) / 5, 0, ONE / 2);
        clocks->clock[CALM].error = clamp_in(noise / 2 + ripple, 0, ONE / 2);
        clocks->clock[QUICK].error = ONE / 4;
    }
    clocks->leader = sd_clock_best(clocks, SD_CRANK_CLOCKS);
    clocks->ratio = 1u << 16;
    self->placed_way.spacings = 0;
    self->last_tick = tick;
}

/* ---- tooth by tooth -------------------------------------------------------------------------------------------- */

/* The angle moved, so what is remembered belongs to other teeth: the memory copies a revolution before it leads. */
void sd_memory_forget(sd_crank_t *self) {
    self->unlearned = self->teeth;
    self->level_left = 0;
    if (clocks_now(self)->leader == MEMORY) { clocks_now(self)->leader = sd_clock_best(clocks_now(self), MEMORY); }
}

/* A revolution is copied as it comes, missing teeth in even parts; with its last tooth the memory joins the clocks. */
static void copy(sd_crank_t *self, uint32_t steps, uint32_t period_ticks) {
    const uint32_t part = (period_ticks << 6) / ((uint32_t)self->placed_way.spacings >> 4); /* of 1/256 spacing */
    uint32_t slot = self->slot;
    for (uint32_t i = 0; i < steps; ++i) {
        self->memory[slot] = part * ((i == 0u) ? (uint32_t)self->placed_way.last >> 4 : 256u);
        slot = (slot > 0u) ? slot - 1u : self->teeth - 1u;
    }
    const int32_t unlearned = (int32_t)self->unlearned - (int32_t)steps;
    self->unlearned = (uint8_t)((unlearned > 0) ? unlearned : 0);
    if (unlearned > 0) { return; }
    sd_crank_clocks_t *clocks = clocks_now(self);
    clocks->clock[MEMORY] = clocks->clock[clocks->leader];
    clocks->clock[MEMORY].change = 0;
    clocks->clock[MEMORY].error = ONE / 8;
    clocks->ratio = 1u << 16;
}

/* After an edge `steps` teeth on, while the memory is not complete. */
void sd_memory_fill(sd_crank_t *self, uint32_t steps, uint32_t period_ticks) {
    if (self->unlearned > 0u) {
        copy(self, steps, period_ticks);
    } else {
        level(self, LEVEL_EACH);
    }
}
