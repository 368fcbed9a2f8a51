/* SPDX-License-Identifier: MIT */
/* The decoder's init with any configuration at all: what it leaves of a wheel that it takes, and the state to begin with, are in the
 * ranges from which crank.c goes on. */
/* options: -eva-precision 1 -eva-slevel 100 -eva-auto-loop-unroll 20 -eva-slevel-function sd_crank_init:3000,sd_wheel_init:3000,collect_marks:3000,marks_stand_apart:500 */
/* specified: sd_inverse_of */
/* include: contracts_crank.h */
/* kernel: firmware/crank/sd_crank.c firmware/crank/sd_crank_clock.c firmware/crank/sd_crank_mark.c firmware/crank/sd_crank_memory.c firmware/crank/sd_crank_search.c firmware/crank/sd_crank_track.c firmware/crank/sd_crank_wheel.c */
#include "any.h"
#include "crank_ranges.h"

static sd_crank_t self;
static sd_crank_config_t config;

static void check_wheel(void) {
    //@ assert positions: SD_CRANK_POSITIONS_MIN <= self.config.positions <= SD_CRANK_POSITIONS_MAX;
    //@ assert stall: 256 <= self.config.stall_ticks <= STALL_TICKS_MAX;
    //@ assert cam: self.config.cam_position < 2 * SD_CRANK_POSITIONS_MAX;
    //@ assert teeth: TEETH_LEAST <= self.teeth <= TEETH_MOST;
    //@ assert marks: 1 <= self.mark_count <= SD_CRANK_MARKS_MAX;
    for (uint32_t i = 0; i < SD_CRANK_MARKS_MAX; i++) {
        //@ assert run: 0 <= self.mark_run[i] <= SD_CRANK_RUN_MAX;
        //@ assert apart: 0 <= self.mark_teeth[i] <= SD_CRANK_POSITIONS_MAX;
        //@ assert width: 0 <= self.mark_spacings[i] <= WIDTH_MOST;
        //@ assert scatter: 0 <= self.mark_scatter[i] <= ONE / 2;
    }
    //@ assert turn: TURN_LEAST <= self.turn_spacings <= TURN_MOST;
}

static void check_begin(void) {
    //@ assert slot: self.slot == 0 && self.level_slot == 0 && self.level_left == 0 && self.unlearned <= TEETH_MOST;
    //@ assert mode: self.mode == WAITING && self.now == 0 && self.pending_mark == SD_CRANK_MARKS_MAX;
    for (uint32_t i = 0; i < SD_CRANK_SIGHTS; i++) {
        //@ assert sight: self.sight[i].mark == 0;
    }
}

int main(void) {
    static const sd_crank_config_t usual = { 60, 2, { 58, 59 }, 1u << 20, 0, 0 };
    (void)sd_crank_init(&self, &usual); /* what a configuration that is refused leaves as it is */
    ANY_BYTES(config);
    (void)sd_crank_init(&self, &config);
    check_wheel();
    check_begin();
    return 0;
}
