/* SPDX-License-Identifier: MIT */
/* The decoder on any wheel: whatever numbers of a wheel crank_init.c says that init may leave, any state in the ranges of fill_state, which
 * every call leaves behind again, any edge of crank or cam, any time. Only differences of times count, so that the last edge is at 0. */
/* options: -eva-precision 0 -eva-slevel 8 -eva-ilevel 128 -eva-auto-loop-unroll 20 -eva-slevel-function sum_turn:50,find_mark:100,find_early:100,sd_search_edge:50,main:100,sd_track_edge:100,next_place:50,nearest_place:60 */
/* specified: sd_inverse_of */
/* include: contracts_crank.h */
/* kernel: firmware/crank/sd_crank.c firmware/crank/sd_crank_clock.c firmware/crank/sd_crank_mark.c firmware/crank/sd_crank_memory.c firmware/crank/sd_crank_search.c firmware/crank/sd_crank_track.c firmware/crank/sd_crank_wheel.c */
#include "any.h"
#include "crank_ranges.h"

static sd_crank_t self;

static void fill_wheel(void) {
    self.config.positions = (uint8_t)any_of(SD_CRANK_POSITIONS_MIN, SD_CRANK_POSITIONS_MAX);
    self.config.has_cam = (uint8_t)any_upto(1u), self.config.cam_position = (uint16_t)any_upto(2u * SD_CRANK_POSITIONS_MAX - 1u);
    self.config.stall_ticks = 256u + any_upto((uint32_t)STALL_TICKS_MAX - 256u);
    self.teeth = (uint8_t)any_of(TEETH_LEAST, TEETH_MOST), self.mark_count = (uint8_t)any_of(1, SD_CRANK_MARKS_MAX);
    for (uint32_t i = 0; i < SD_CRANK_MARKS_MAX; i++) {
        self.mark_first[i] = (uint8_t)any_upto(255u), self.mark_run[i] = (uint8_t)any_of(0, SD_CRANK_RUN_MAX);
        self.mark_teeth[i] = (uint8_t)any_of(0, SD_CRANK_POSITIONS_MAX);
    }
    self.mark_at = any_u32(), self.search_marks = (uint8_t)any_upto(255u);
}

static void fill_clocks(sd_crank_clocks_t *clocks) {
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; i++) {
        const int32_t grows = (i == (uint32_t)MEMORY) ? TIME_MAX : PERIOD_MAX >> 3;
        clocks->clock[i] = (sd_crank_clock_t){ any_u32(), any_of(PERIOD_MIN, PERIOD_MAX), any_of(-grows, grows), any_of(0, ONE / 2) };
    }
    clocks->ratio = (uint32_t)any_of(RATIO_MIN, RATIO_MAX);
    clocks->leader = any_upto(SD_CRANK_CLOCKS - 1u);
}

static void check_clocks(const sd_crank_clocks_t *clocks) {
    for (uint32_t i = 0; i < SD_CRANK_CLOCKS; i++) {
        const int32_t grows = (i == (uint32_t)MEMORY) ? TIME_MAX : PERIOD_MAX >> 3;
        //@ assert period: PERIOD_MIN <= clocks->clock[i].period <= PERIOD_MAX;
        //@ assert change: -grows <= clocks->clock[i].change <= grows;
        //@ assert error: 0 <= clocks->clock[i].error <= ONE / 2;
    }
    //@ assert ratio: RATIO_MIN <= clocks->ratio <= RATIO_MAX;
    //@ assert leader: clocks->leader < SD_CRANK_CLOCKS;
}

static void fill_marks(void) {
    for (uint32_t i = 0; i < SD_CRANK_MARKS_MAX; i++) {
        self.mark_spacings[i] = any_of(0, WIDTH_MOST);
        self.mark_scatter[i] = any_of(0, ONE / 2);
    }
    self.turn_spacings = any_of(TURN_LEAST, TURN_MOST);
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; i++) {
        ANY_BYTES(self.sight[i]);
        self.sight[i].mark = (uint8_t)any_upto(SD_CRANK_MARKS_MAX - 1u);
    }
    self.pending_mark = (uint8_t)any_upto(SD_CRANK_MARKS_MAX);
}

static void check_marks(void) {
    for (uint32_t i = 0; i < SD_CRANK_MARKS_MAX; i++) {
        //@ assert spacings: 0 <= self.mark_spacings[i] <= WIDTH_MOST;
        //@ assert scatter: 0 <= self.mark_scatter[i] <= ONE / 2;
    }
    //@ assert turn: TURN_LEAST <= self.turn_spacings <= TURN_MOST;
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; i++) {
        //@ assert sight: self.sight[i].mark < SD_CRANK_MARKS_MAX;
    }
    //@ assert pending: self.pending_mark <= SD_CRANK_MARKS_MAX;
}

static void fill_state(uint32_t mode) {
    fill_wheel();
    ANY_BYTES(self.counts);
    fill_clocks(&self.clocks[0]);
    fill_clocks(&self.clocks[1]);
    fill_marks();
    self.placed_way = (sd_crank_way_t){ any_of(0, WAY_MOST), any_of(0, WIDTH_MOST), any_u32(), any_u32() };
    self.placed_late = any_of(-LATE_MOST, LATE_MOST), self.placed_excused = any_of(-ONE, ONE);
    self.mark_late = any_of(-LATE_MOST, LATE_MOST);
    for (uint32_t i = 0; i < SD_CRANK_POSITIONS_MAX; i++) { self.memory[i] = any_u32(); }
    self.last_tick = any_u32(), self.raw_tick = 0;
    for (uint32_t i = 0; i < 4u; i++) { self.raw_period[i] = any_upto(STALL_TICKS_MAX); }
    self.noise = any_u32(), self.hum = any_u32(), self.mean = any_u32(), self.uneven = any_u32();
    self.grown_now = any_u32(), self.grown_before = any_u32();
    self.level = any_of(INT32_MIN, INT32_MAX), self.level_step = any_of(INT32_MIN, INT32_MAX);
    self.strain = any_of(0, ONE);
    self.travel = any_of(INT32_MIN, INT32_MAX), self.mark_travel = any_of(INT32_MIN, INT32_MAX);
    for (uint32_t i = 0; i < SD_CRANK_WITNESSES; i++) { self.witness[i] = any_of(INT32_MIN, INT32_MAX); }
    self.witness_next = (uint8_t)any_upto(SD_CRANK_WITNESSES - 1u);
    self.slot = (uint8_t)any_upto(TEETH_MOST - 1), self.level_slot = (uint8_t)any_upto(TEETH_MOST - 1);
    self.level_left = (uint8_t)any_upto(TEETH_MOST), self.unlearned = (uint8_t)any_upto(TEETH_MOST);
    self.fault_age = (uint8_t)any_upto(255u), self.gap_age = (uint8_t)any_upto(255u);
    self.provisional = (uint8_t)any_upto(1u), self.now = (uint8_t)any_upto(1u);
    self.odd_periods = (uint8_t)any_upto(255u);
    self.mode = (uint8_t)mode;
    self.position = (uint8_t)any_upto(255u);
    self.revolution = (uint8_t)any_upto(1u);
    self.suspected_slip = (int8_t)any_of(-3, 3);
    self.missed = (uint8_t)any_upto(255u), self.rejected = (uint8_t)any_upto(255u), self.mark_clean = (uint8_t)any_upto(1u);
    self.unsure = (uint8_t)any_upto(1u), self.doubtful = (uint8_t)any_upto(1u), self.phase_votes = (uint8_t)any_upto(2u);
}

static void check_state(void) {
    check_clocks(&self.clocks[0]);
    check_clocks(&self.clocks[1]);
    check_marks();
    //@ assert way: 0 <= self.placed_way.spacings <= WAY_MOST;
    //@ assert last: 0 <= self.placed_way.last <= WIDTH_MOST;
    //@ assert late: -LATE_MOST <= self.placed_late <= LATE_MOST && -LATE_MOST <= self.mark_late <= LATE_MOST;
    //@ assert excused: -ONE <= self.placed_excused <= ONE;
    for (uint32_t i = 0; i < 4u; i++) {
        //@ assert raw: self.raw_period[i] <= STALL_TICKS_MAX;
    }
    //@ assert strain: 0 <= self.strain <= ONE;
    //@ assert places: self.witness_next < SD_CRANK_WITNESSES && self.slot < TEETH_MOST && self.level_slot < TEETH_MOST;
    //@ assert left: self.level_left <= TEETH_MOST && self.unlearned <= TEETH_MOST;
    //@ assert small: self.provisional <= 1 && self.now <= 1 && self.mode <= SYNCED && self.revolution <= 1 && self.phase_votes <= 2;
    //@ assert flags: self.mark_clean <= 1 && self.unsure <= 1 && self.doubtful <= 1 && -3 <= self.suspected_slip <= 3;
}

static void edge(uint32_t mode, uint32_t tick) {
    sd_tooth_t tooth;
    fill_state(mode);
    sd_crank_edge(&self, tick, &tooth);
    //@ assert said: \initialized(&tooth) && tooth.cycle_position < 1024;
    check_state();
}

static void call_all(uint32_t mode) {
    edge(mode, any_upto((uint32_t)STALL_TICKS_MAX));
    edge(mode, (uint32_t)STALL_TICKS_MAX + 1u + any_upto(UINT32_MAX - (uint32_t)STALL_TICKS_MAX - 1u));
    fill_state(mode);
    sd_crank_cam_edge(&self, any_u32());
    check_state();
    fill_state(mode);
    (void)sd_crank_poll(&self, any_u32());
    check_state();
    fill_state(mode);
    sd_crank_lose_sync(&self);
    (void)sd_crank_set_stall(&self, any_u32());
    check_state();
}

int main(void) {
    for (uint32_t mode = WAITING; mode <= (uint32_t)SYNCED; mode++) { call_all(mode); }
    return 0;
}
