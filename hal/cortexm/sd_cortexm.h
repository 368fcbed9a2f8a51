/* SPDX-License-Identifier: MIT */
/// sd_cortexm.h - the port of a controller: what interrupts saw waits here in order until the ecu has handled it, and the port says
/// when teeth come faster than that.
///
///   capture interrupt  (first priority)   sd_cortexm_edge    takes the time of an edge, some 30 instructions, and asks for work
///   work interrupt     (second)           sd_cortexm_next    hands the events to sd_ecu_run, one by one
///   clock and samples  (third)            sd_cortexm_post    reads sensors
///   10 ms task         (last)             sd_cortexm_task_done  after sd_ecu_task_run, the task's long part
///
/// Edges have a queue of their own with one writer, everything else another one, whose writers have one priority; so neither needs a
/// lock. Edges go first.
///
/// The 10 ms task: a clock event is handed out with SD_TIME_PUT_OFF, whereupon the ecu leaves the task's long part to the last priority.
/// Teeth interrupt that. Until it is done only edges are handed out, and no sample or parameter, so that nothing changes what the task
/// reads; then follows SD_EVENT_TASK, by which the ecu says what came of it. A clock event that comes before is late: it waits, is counted
/// in `tasks_late`, and SD_EVENT_TASK says so.
///
/// Overrun: an edge is captured while the one before it has not been handled. The queue keeps it, so no edge is lost, but the ecu is
/// behind. The port then says SD_EVENT_LATE with one level more, and the ecu leaves out work (sd_shed_t in sd_shed.h) and says so in the
/// health of what it leaves out. After `patience` edges without an overrun the port takes a level back; an overrun within so many edges
/// of that doubles the patience, one after a longer calm makes it what it was at first. Where the queue is full an edge is lost: the port
/// says SD_EVENT_GAP.
///
/// Since all of it is events, a run that was recorded on a target is the same to the bit when it is replayed.
#ifndef SD_CORTEXM_H
#define SD_CORTEXM_H
#include <stdbool.h>

#include "hal.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_CORTEXM_EDGES       32u   ///< Edges that may wait, a power of two.
#define SD_CORTEXM_OTHERS      64u   ///< Samples and clock events that may wait, a power of two.
#define SD_CORTEXM_PATIENCE    480u  ///< Edges without an overrun before a level is taken back: four cycles of 60 positions.
#define SD_CORTEXM_PATIENCE_MAX 30720u ///< It grows no further than that.

/// All zero is a valid start, but for patience: sd_cortexm_init.
typedef struct sd_cortexm {
    sd_event_t edges[SD_CORTEXM_EDGES];   ///< flags 1: edges were lost right before it.
    sd_event_t others[SD_CORTEXM_OTHERS];
    volatile uint32_t edges_written, others_written; ///< Run on and wrap; each has one priority that writes it.
    volatile uint32_t edges_read, others_read; ///< Run on and wrap; the work interrupt writes them.
    volatile uint32_t crank_seen, crank_done; ///< Crank edges captured, and handled.
    volatile uint32_t overruns;     ///< Edges captured while the one before was not handled, wraps.
    volatile uint32_t lost_edges;   ///< Edges for which the queue had no room, wraps.
    volatile uint32_t lost_others;  ///< Samples and clock events likewise, wraps.
    volatile uint32_t tasks_late;   ///< Clock events that came before the task of the last one was done, wraps.
    uint32_t tasks_late_said;       ///< Of `tasks_late`, by the last SD_EVENT_TASK.
    uint32_t task_tick;             ///< Of the clock event that the task belongs to.
    volatile uint8_t  task;         ///< 0: none; 1: its long part is under way; 2: that is done.
    volatile uint8_t  losing;       ///< 1: edges have been lost since the last one that was queued.
    uint8_t  level;                 ///< sd_shed_t that the ecu was told.
    uint8_t  taken_back;            ///< 1: the last change of level took one back.
    uint8_t  handling;              ///< 1: the event handed out last is a crank edge.
    uint32_t overruns_answered;     ///< Of `overruns`.
    uint32_t calm, patience;        ///< Edges since the last overrun or change of level; how many it takes.
} sd_cortexm_t;

/// Empties the queues and forgets every count.
void sd_cortexm_init(sd_cortexm_t *self);

/// Of the capture interrupt: an edge of crank or cam at `tick`. Never blocks.
void sd_cortexm_edge(sd_cortexm_t *self, sd_event_kind_t kind, uint32_t tick);

/// Of interrupts of the third priority: a sample or a clock event.
void sd_cortexm_post(sd_cortexm_t *self, const sd_event_t *event);

/// Whether sd_ecu_task_run is due. Asked by the work interrupt when nothing waits any more.
static inline bool sd_cortexm_task_due(const sd_cortexm_t *self) { return self->task == 1u; }

/// Of the last priority: sd_ecu_task_run has returned. Then the work is due again.
void sd_cortexm_task_done(sd_cortexm_t *self);

/// Of the work interrupt: the next event for the ecu; false when there is none. By the call for the next one the last one has been
/// handled.
bool sd_cortexm_next(sd_cortexm_t *self, sd_event_t *event);

#ifdef __cplusplus
}
#endif
#endif
