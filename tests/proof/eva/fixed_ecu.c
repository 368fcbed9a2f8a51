/* SPDX-License-Identifier: MIT */
/* The ecu of fixed point: init, one event of each kind, the 10 ms task; any state in the ranges of fixed_state.h, which an event leaves
 * behind again, any page that init takes, any event. Kernels are what contracts_fixed.h says of them, pieces of a cycle's work too. */
/* options: -eva-precision 0 -eva-slevel 12 -eva-auto-loop-unroll 26 -eva-slevel-function sd_ecu_tooth:60,sd_course_ended:60,sd_work_edge:60,end_window:20,sd_stage_work_edge:40 */
/* specified: sd_sat_q31 sd_root_q31 sd_reciprocal */
/* include: contracts_fixed.h contracts_bases.h */
/* kernel: firmware/ecu_fixed/sd_ecu_fixed.c firmware/ecu_fixed/sd_fixed_say.c firmware/ecu_fixed/sd_fixed_misfire.c firmware/ecu_fixed/sd_fixed_mixture.c firmware/ecu/sd_ecu_events.c firmware/ecu/sd_ecu_command.c firmware/ecu/sd_course.c firmware/ecu/sd_inputs.c firmware/ecu/sd_publish.c firmware/ecu/sd_say_airpath.c firmware/ecu/sd_stage_airpath_q31.c firmware/ecu/sd_stage_work.c firmware/torque/sd_work.c firmware/torque/sd_work_q31.c firmware/page/sd_calibration.c hal/generated/sd_signals.c */
#include "fixed_state.h"

static uint16_t kind;
static uint32_t left;

static uint32_t receive(void *context, sd_event_t *events, uint32_t room) {
    (void)context, (void)room;
    if (left == 0u) { return 0u; }
    left--;
    ANY_BYTES(*events);
    events->kind = kind;
    return 1u;
}
static const sd_port_t port = { 0, receive, send };

static void check_state(void) {
    //@ assert crank: in_range(&self.crank);
    //@ assert at: self.energy.at < SD_WORK_WINDOWS_MAX;
    //@ assert ticks: self.energy.ticks <= TICKS_MOST && self.energy.last_ticks <= TICKS_MOST;
    //@ assert first: self.mixture.waiting_first < SD_MIXTURE_WAITING;
    //@ assert waiting: self.mixture.waiting_count <= SD_MIXTURE_WAITING;
}

static void event_of(uint16_t of, bool windows) {
    fill_page(windows);
    fill_state(windows, SD_FIXED_NONE, 0);
    kind = of, left = 1;
    (void)sd_ecu_run(&self, &page, &port);
    check_state();
}

int main(void) {
    //@ widen_hints global:"all", 32;
    event_of(SD_EVENT_CRANK_EDGE, false);
    for (uint16_t of = 0; of <= SD_EVENT_TASK + 1; of++) { event_of(of, true); }
    fill_state(true, SD_FIXED_NONE, 0);
    sd_ecu_task_run(&self, &page);
    check_state();
    ANY_BYTES(page); /* what a page may say before it is looked at */
    (void)sd_calibration_in_range(&page);
    fill_page(true);
    (void)sd_ecu_init(&self, &page);
    return 0;
}
