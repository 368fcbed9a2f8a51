/* SPDX-License-Identifier: MIT */
/// sd_crank.h - crank decoder: captured edges of a toothed wheel in; tooth, angle, speed, cycle phase, health out.
///
/// The decoder tracks phase instead of hunting gaps. Four clocks predict when the next tooth comes: a quick and a
/// middle one follow changes of speed, a calm one averages edge jitter, and one remembers how long each tooth took in
/// past revolutions, so that compression ripple while cranking does not surprise it, nor what lies behind a missing
/// tooth or the mark; the one whose predictions have been better leads. An edge is placed on the tooth position it
/// comes nearest to, so a missing tooth is coasted through and a doubled or spurious edge is left out, whatever
/// happens elsewhere. The mark (missing teeth) is only looked for where it should be: after each pass the edges
/// around it vote on whether the angle holds or has slipped by a few teeth, which is then put right. Theory and
/// measured figures: docs/crank.md.
///
/// Real-time contract: integer arithmetic only, no heap, no globals, loops bounded by the constants below; one
/// writer per state. Call order: sd_crank_init once; then sd_crank_edge for each crank edge, sd_crank_cam_edge for
/// each cam edge, and sd_crank_poll from a slow task (10 ms) so that a stall shows without an edge.
#ifndef SD_CRANK_H
#define SD_CRANK_H
#include <stdbool.h>
#include <stdint.h>

#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_CRANK_POSITIONS_MIN 12u
#define SD_CRANK_POSITIONS_MAX 120u
#define SD_CRANK_MISSING_MAX   12u ///< Missing positions of a wheel.
#define SD_CRANK_MARKS_MAX     4u  ///< Runs of missing positions of a wheel.
#define SD_CRANK_RUN_MAX       3u  ///< Missing positions in one run.
#define SD_CRANK_COAST_MAX     8u  ///< Positions the decoder coasts without an edge before it gives up sync.
#define SD_CRANK_WITNESSES     16u ///< Edges remembered for the vote on the mark.
#define SD_CRANK_CLOCKS        4u

/// Tooth spacings are Q12: 4096 is the distance between two neighbouring teeth.
#define SD_SPACING_ONE 4096

/// The wheel and the capture timer. Read by init only.
typedef struct sd_crank_config {
    uint8_t  positions;                     ///< Tooth positions a revolution, missing ones included, 12 to 120.
    uint8_t  missing_count;                 ///< 1 to SD_CRANK_MISSING_MAX.
    uint8_t  missing[SD_CRANK_MISSING_MAX]; ///< Missing positions, ascending, runs of 1 to 3, last = positions - 1.
    uint32_t stall_ticks;   ///< A tooth spacing longer than this is a stall, 256 to 2^24 capture ticks.
    uint8_t  has_cam;       ///< 1: cam edges give the phase; 0: the phase stays unknown.
    uint16_t cam_position;  ///< Cycle position of the cam edge, 0 to 2 * positions - 1.
} sd_crank_config_t;

/// What became of an edge.
typedef enum sd_edge_class {
    SD_EDGE_TOOTH    = 0, ///< A tooth, where and when it was expected.
    SD_EDGE_COASTED  = 1, ///< A tooth, placed by the clocks: one or more before it were missing.
    SD_EDGE_SPURIOUS = 2, ///< Not a tooth; left out.
    SD_EDGE_UNSYNCED = 3, ///< The angle is not known (yet, or any more).
} sd_edge_class_t;

/// One decoded edge.
typedef struct sd_tooth {
    uint32_t tick;           ///< Capture time of the edge.
    uint32_t period_ticks;   ///< Since the last placed edge; 0 when there is none.
    uint32_t span_spacings;  ///< Tooth spacings in that period, Q12; a mark counts as learned, not as drawn.
    uint16_t cycle_position; ///< position + positions * revolution, 0 to 2 * positions - 1.
    uint16_t why;            ///< sd_why_t bits.
    uint8_t  position;       ///< Tooth position, 0 = first tooth after the mark.
    uint8_t  advance;        ///< Positions since the last placed edge, missing ones included; 1 to 255.
    uint8_t  edge_class;     ///< sd_edge_class_t.
    uint8_t  health;         ///< sd_health_t of position, period and span. The phase has its own flag.
    uint8_t  phase_known;    ///< 1: cycle_position counts from the right revolution.
} sd_tooth_t;

/// Counters since init; all wrap.
typedef struct sd_crank_counts {
    uint32_t edges;         ///< Crank edges taken.
    uint32_t sync_gains, sync_losses;
    uint32_t coasted;       ///< Tooth positions passed without an edge.
    uint32_t spurious;      ///< Edges left out while in sync.
    uint32_t slips;         ///< Times the vote at a mark moved the angle.
    uint32_t marks_missed;  ///< Marks whose vote could not confirm the angle.
    uint32_t stalls;
    uint32_t cam_rejected;  ///< Cam edges far from where they belong, or without crank sync.
} sd_crank_counts_t;

/// Predicts tooth times: time after u spacings = period u + change u (u + 1) / 2; the clock with the memory scales the
/// remembered times by period over remembered period instead. Times in 1/64 tick.
typedef struct sd_crank_clock {
    uint32_t tick;     ///< Fitted time of the last placed edge, whole ticks.
    int32_t  frac;     ///< Its fraction, 1/64 tick, [0, 64).
    int32_t  period;   ///< Ticks per spacing, 1/64 tick.
    int32_t  change;   ///< Growth of period per spacing, 1/64 tick.
    int32_t  error;    ///< Running mean of |prediction error|, Q12 spacings.
} sd_crank_clock_t;

/// A way of one or more tooth spacings, measured by the teeth and by the memory of past revolutions.
typedef struct sd_crank_way {
    int64_t recalled;                ///< Time it took, 1/64 tick.
    int32_t spacings;                ///< Q12.
    int32_t period_from, period_to;  ///< Remembered period before it and at its end, 1/64 tick.
} sd_crank_way_t;

/// Decoder state: plain data, caller-owned, copyable, comparable. Fields are for logs; write none of them.
typedef struct sd_crank {
    sd_crank_config_t config;
    sd_crank_counts_t counts;
    sd_crank_clock_t  clock[SD_CRANK_CLOCKS];  ///< Quick, middle, memory, calm.
    sd_crank_clock_t  before[SD_CRANK_CLOCKS]; ///< The same before the last placed edge.
    sd_crank_way_t placed_way;              ///< From `before` to the last placed edge.
    int32_t  placed_late, placed_excused;   ///< The last placed edge as seen from `before`, Q12.
    uint32_t memory[SD_CRANK_POSITIONS_MAX];///< Time from the tooth before to each tooth, 1/64 tick; 0: not known yet.
    int32_t  memory_period;                 ///< Remembered period at the last placed edge, 1/64 tick.
    int32_t  mark_spacings[SD_CRANK_MARKS_MAX]; ///< Learned width of each mark, Q12.
    int32_t  mark_scatter[SD_CRANK_MARKS_MAX];  ///< How far the first tooth after it strays from that width, Q12.
    int32_t  turn_spacings;                 ///< Spacings in a revolution, Q12: teeth - marks + widths of the marks.
    uint32_t last_tick, raw_tick, raw_period[2]; ///< Last placed edge; last edge of any kind and its two periods.
    int32_t  strain;                        ///< Largest error of the leading clock since the angle was last confirmed.
    int32_t  travel;                        ///< Spacings travelled, Q12, wraps.
    int32_t  mark_travel;                   ///< Travel at the tooth before the mark being voted on.
    int32_t  mark_late;                     ///< How late the tooth after that mark was, Q12.
    int32_t  witness[SD_CRANK_WITNESSES];   ///< Travel at the last edges of any kind.
    uint8_t  witness_count, witness_next;
    uint8_t  mark_count, mark_first[SD_CRANK_MARKS_MAX], mark_run[SD_CRANK_MARKS_MAX]; ///< First missing position, run.
    uint8_t  odd_periods;     ///< Even periods in a row that disagree with the leading clock.
    uint8_t  leader, before_leader; ///< Which clock leads, and led `before`.
    uint8_t  mode;            ///< Waiting, searching, trying, synced (sd_crank.c).
    uint8_t  position;        ///< Of the last placed edge.
    uint8_t  revolution;      ///< 0 or 1, meaningful with phase_votes at its limit.
    uint8_t  pending_mark;    ///< Mark whose vote is due, or SD_CRANK_MARKS_MAX.
    uint8_t  confirmed;       ///< Marks confirmed in a row while trying.
    int8_t   suspected_slip;  ///< Slip that the last vote found but had no reason to believe.
    uint8_t  missed;          ///< Marks missed in a row while synced.
    uint8_t  try_mark;        ///< Which mark the next gap is taken for; moves on when a try fails.
    uint8_t  rejected;        ///< Edges left out in a row.
    uint8_t  mark_clean;      ///< That mark was passed with both teeth beside it and nothing between.
    uint8_t  unsure;          ///< The angle may have slipped; until the next vote no tooth is valid.
    uint8_t  doubtful;        ///< The last placed edge was coasted to or far off.
    uint8_t  phase_votes;     ///< Cam edges that agreed with the present revolution, saturating.
} sd_crank_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_crank_init(sd_crank_t *self, const sd_crank_config_t *config);

/// Takes one crank edge captured at `tick` (wraps; edges in time order). Fills *tooth.
void sd_crank_edge(sd_crank_t *self, uint32_t tick, sd_tooth_t *tooth);

/// Takes `count` edges in time order and fills as many teeth; the same result as one by one.
void sd_crank_edges(sd_crank_t *self, const uint32_t *ticks, uint32_t count, sd_tooth_t *teeth);

/// Takes one cam edge. Two in a row within 45 deg of cam_position that agree set the phase; one that contradicts
/// a known phase makes it unknown again.
void sd_crank_cam_edge(sd_crank_t *self, uint32_t tick);

/// Tells the time. Returns true when this call found the engine stalled: sync and phase are gone.
bool sd_crank_poll(sd_crank_t *self, uint32_t tick);

/// Edges were lost on their way here: angle and phase are unknown, and sought afresh from the next edge on.
void sd_crank_lose_sync(sd_crank_t *self);

/// Changes config.stall_ticks; the angle stays. SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_crank_set_stall(sd_crank_t *self, uint32_t stall_ticks);

/// Speed over tooth->period_ticks, rad/s; 0 when there is no period. tick_hz: capture ticks a second, > 0.
float sd_crank_speed_radps(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz);

/// Angular acceleration from the leading clock, rad/s^2; 0 when there is no period.
float sd_crank_acceleration_radps2(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz);

#ifdef __cplusplus
}
#endif

#endif
