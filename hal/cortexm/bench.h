/* SPDX-License-Identifier: MIT */
/// bench.h - events that lie in RAM and happen at their own times: edges by the interrupt of a timer whose period changes from edge to
/// edge, everything else by a task of lower priority, as on a board.
#ifndef SD_BENCH_H
#define SD_BENCH_H
#include "hal.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Takes an event of the bench.
typedef void bench_taker_t(const sd_event_t *event);

uint32_t bench_count(void); ///< Events of the bench; 0: there is none.
/// Lets all of them happen; returns when the last one has been taken.
void bench_run(void);
/// Of the capture interrupt: hands over every edge that is due, makes the task due for what else is, and sets the timer for the next one.
void bench_capture(bench_taker_t *edge);
/// Of the task: hands over what is due beside edges.
void bench_task(bench_taker_t *other);
/// The edge at `tick` has been handled.
void bench_handled(uint32_t tick);
/// The longest time from an edge until it had been handled, in ticks of 40 ns.
uint32_t bench_longest(void);

#ifdef __cplusplus
}
#endif

#endif
