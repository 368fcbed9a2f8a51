/* SPDX-License-Identifier: MIT */
/// sd_link.h - what goes between an emulated controller and the host, over its standard input and output, by semihosting.
///
/// All words are 32 bits, little endian. The image begins with sd_link_hello_t. The host then asks: a word says how many events follow,
/// 1 to SD_LINK_EVENTS. The image answers with one frame for each event that its ecu has handled, in order: sd_link_frame_t and the
/// events that the ecu said; what it says of the 10 ms task stands in the frame of the clock event. A word 0 asks for the end: the image
/// answers with a last frame and sd_link_end_t, and leaves.
///
/// With a bench of events in RAM (sd_board.h) the image asks for nothing: it lets them happen at their own times, by interrupts of the
/// board's timers, sends frames all the while, those of SD_EVENT_TASK too, and the end.
#ifndef SD_LINK_H
#define SD_LINK_H
#include "hal.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_LINK_MAGIC  0x4c434453u ///< "SDCL"
#define SD_LINK_EVENTS 64u         ///< Most events of one question.
#define SD_LINK_LAST   0xffffffffu ///< In place of a count: the end.

/// Whether the image took its page.
typedef enum sd_link_state {
    SD_LINK_READY        = 0, ///< It did.
    SD_LINK_PAGE_REFUSED = 1, ///< The page is damaged or made for another table of signals.
    SD_LINK_INIT_REFUSED = 2, ///< A number of the page is out of its range.
} sd_link_state_t;

/// The image says this first.
typedef struct sd_link_hello {
    uint32_t magic;      ///< SD_LINK_MAGIC.
    uint32_t signature;  ///< SD_SIGNALS_SIGNATURE of the image.
    uint32_t state;      ///< sd_link_state_t.
    uint32_t ecu_bytes;  ///< sizeof(sd_ecu_t).
} sd_link_hello_t;

/// The image says this of each event.
typedef struct sd_link_frame {
    uint32_t   count; ///< Events said, which follow. SD_LINK_LAST: there was no event; the end follows.
    uint32_t   ticks; ///< Of the core's timer, that the ecu took for it; 40 ns each.
    sd_event_t in;    ///< The event that was handled. The port's own are among them (SD_EVENT_LATE, SD_EVENT_GAP).
} sd_link_frame_t;

/// The image says this last.
typedef struct sd_link_end {
    uint32_t stack_bytes; ///< Used by interrupts and program, of the run.
    uint32_t overruns;    ///< Crank edges captured while the one before was not handled.
    uint32_t lost_edges;  ///< Edges for which there was no room.
    uint32_t lost_others; ///< Samples and clock events likewise.
    uint32_t longest;     ///< With a bench: longest time from a crank edge until it had been handled, in ticks of 40 ns.
    uint32_t nested;      ///< Edges captured while the ecu was at work.
    uint32_t interrupted; ///< Crank edges handled during the long part of the 10 ms task.
    uint32_t tasks_late;  ///< Clock events that came before the task of the last one was done.
} sd_link_end_t;

#ifdef __cplusplus
}
#endif

#endif
