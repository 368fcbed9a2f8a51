/* SPDX-License-Identifier: MIT */
/// sd_crank.h - crank decoder: captured edges of a toothed wheel in; tooth, angle, speed, cycle phase, health out.
///
/// Searching, it follows every interval that stands out against its neighbours as a gap that may be the mark; the one that
/// comes again after as many edges as the wheel has teeth, and as wide, is the mark. That takes no prediction, so neither
/// compression ripple nor odd teeth beside the mark keep it from starting. Over faults the angle counts as unsure until the
/// next mark confirms it.
///
/// Then it tracks phase instead of hunting gaps. Three clocks predict when the next tooth comes: a quick one follows changes
/// of speed, a calm one averages edge jitter, and one remembers how long each tooth took in past revolutions, so that ripple
/// while cranking does not surprise it, nor what lies behind a missing tooth or the mark; the one whose predictions have been
/// better leads. An edge is placed on the tooth position it comes nearest to, so a missing tooth is coasted through and a
/// doubled or spurious edge is left out, whatever happens elsewhere. After each pass of the mark the edges around it vote on
/// whether the angle holds or has slipped by a few teeth, which is then put right. Theory: docs/theory/crank.md; figures:
/// docs/results/crank.md.
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

#define SD_CRANK_POSITIONS_MIN 12u  ///< Fewest positions of a wheel.
#define SD_CRANK_POSITIONS_MAX 120u ///< Most positions of a wheel.
#define SD_CRANK_MISSING_MAX   12u ///< Missing positions of a wheel.
#define SD_CRANK_MARKS_MAX     4u  ///< Runs of missing positions of a wheel.
#define SD_CRANK_RUN_MAX       3u  ///< Missing positions in one run.
#define SD_CRANK_COAST_MAX     8u  ///< Positions the decoder coasts without an edge before it gives up sync.
#define SD_CRANK_WITNESSES     16u ///< Edges remembered for the vote on the mark.
#define SD_CRANK_CLOCKS        3u  ///< Predictions of the next tooth beside each other.
#define SD_CRANK_SIGHTS        6u  ///< Gaps followed at a time while searching.

/// Tooth spacings are Q12: 4096 is the distance between two neighbouring teeth.
#define SD_SPACING_ONE 4096

/// The wheel and the capture timer. Read by init only.
typedef struct sd_crank_config {
    uint8_t  positions;                     ///< Tooth positions a revolution, missing ones included, 12 to 120.
    uint8_t  missing_count;                 ///< 1 to SD_CRANK_MISSING_MAX.
    uint8_t  missing[SD_CRANK_MISSING_MAX]; ///< Missing positions, ascending, runs of 1 to 3, last = positions - 1. Runs have at
                                            ///< least four teeth between them, or two as wide as each other have one.
    uint32_t stall_ticks;   ///< An interval longer than this is a stall, 256 to 2^24 capture ticks. Teeth further apart than
                            ///< 2^23 ticks are not followed.
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
    uint32_t sync_gains, sync_losses; ///< Times the angle was found, and lost.
    uint32_t coasted;       ///< Tooth positions passed without an edge.
    uint32_t spurious;      ///< Edges left out while in sync.
    uint32_t slips;         ///< Times the vote at a mark moved the angle.
    uint32_t marks_missed;  ///< Marks whose vote could not confirm the angle.
    uint32_t stalls;        ///< Times the engine was found at rest.
    uint32_t cam_rejected;  ///< Cam edges far from where they belong, or without crank sync.
} sd_crank_counts_t;

/// Predicts tooth times: time after u spacings = period u + change u (u + 1) / 2. The clock with the memory takes the
/// remembered times by `ratio` instead.
typedef struct sd_crank_clock {
    uint32_t time;     ///< Fitted time of the last placed edge, 1/64 tick, wraps.
    int32_t  period;   ///< Time of one spacing, 1/64 tick.
    int32_t  change;   ///< Growth of period per spacing, 1/64 tick.
    int32_t  error;    ///< Running mean of |prediction error|, Q12 spacings.
} sd_crank_clock_t;

/// The clocks as they stand after a placed edge.
typedef struct sd_crank_clocks {
    sd_crank_clock_t clock[SD_CRANK_CLOCKS]; ///< Quick, memory, calm.
    uint32_t ratio;    ///< Time of a spacing now over the remembered, Q16.
    uint32_t leader;   ///< Which clock leads.
} sd_crank_clocks_t;

/// A way of one or more tooth spacings.
typedef struct sd_crank_way {
    int32_t  spacings;   ///< Q12.
    int32_t  last;       ///< Spacings of its last step, Q12.
    uint32_t recalled;   ///< Time it took in the memory, 1/64 tick.
    uint32_t recalled_last; ///< Remembered time of its last step, 1/64 tick.
} sd_crank_way_t;

/// Search: a gap that may be mark `mark`, followed from there on.
typedef struct sd_crank_sight {
    uint8_t  hits;     ///< Gaps in a row where a mark should be; 0: unused.
    uint8_t  mark;     ///< The mark last passed.
    uint8_t  raw;      ///< Edges since then.
    uint8_t  mended;   ///< The same with missing teeth added and spurious edges taken off.
    uint8_t  clean;    ///< Hits in a row without a fault on the way.
    uint8_t  strange;  ///< Other gaps as wide seen on the way.
    uint16_t width;    ///< Gap over the mean of its neighbours, Q8.
    uint16_t side;     ///< Gap over the interval before it, Q8.
} sd_crank_sight_t;

/// Decoder state: plain data, caller-owned, copyable, comparable. Fields are for logs; write none of them.
typedef struct sd_crank {
    sd_crank_config_t config;
    sd_crank_counts_t counts;
    sd_crank_clocks_t clocks[2];            ///< After the last placed edge (index `now`) and before it.
    sd_crank_way_t placed_way;              ///< From the clocks before to the last placed edge; 0 spacings: none.
    int32_t  placed_late, placed_excused;   ///< The last placed edge as seen from there, Q12.
    uint32_t memory[SD_CRANK_POSITIONS_MAX];///< Time from the tooth before to each tooth, 1/64 tick, by slot. While
                                            ///< searching: the intervals of the last revolution.
    int32_t  mark_spacings[SD_CRANK_MARKS_MAX]; ///< Learned width of each mark, Q12.
    int32_t  mark_scatter[SD_CRANK_MARKS_MAX];  ///< How far the first tooth after it strays from that width, Q12.
    int32_t  turn_spacings;                 ///< Spacings in a revolution, Q12: teeth - marks + widths of the marks.
    uint32_t last_tick;                     ///< Last placed edge.
    uint32_t raw_tick, raw_period[4];       ///< Last edge of any kind and the intervals before it, newest first.
    uint32_t noise;                         ///< Searching: how far edges stray from even, ticks * 16.
    uint32_t hum;                           ///< Searching: the same with outliers cut off.
    uint32_t mean, uneven;                  ///< Searching: fading mean of intervals, and of how far they are from it, ticks * 16.
    uint32_t grown_now, grown_before;       ///< Searching: fading sums of intervals now and a revolution ago, 1/64 tick.
    int32_t  level, level_step;             ///< After sync: what the next old interval is to be multiplied by, Q20.
    int32_t  strain;                        ///< Largest error of the leading clock since the angle was last confirmed.
    int32_t  travel;                        ///< Spacings travelled, Q12, wraps.
    int32_t  mark_travel;                   ///< Travel at the tooth before the mark being voted on.
    int32_t  mark_late;                     ///< How late the tooth after that mark was, Q12.
    int32_t  witness[SD_CRANK_WITNESSES];   ///< Travel at the last edges of any kind.
    uint32_t mark_at;                       ///< First missing position of mark m in byte m from the lowest on; 255: no such mark.
    sd_crank_sight_t sight[SD_CRANK_SIGHTS];
    uint8_t  witness_next;                  ///< Where the next edge goes in `witness`.
    uint8_t  mark_count, mark_first[SD_CRANK_MARKS_MAX], mark_run[SD_CRANK_MARKS_MAX]; ///< First missing position, run.
    uint8_t  mark_teeth[SD_CRANK_MARKS_MAX]; ///< Teeth from each mark to the next; to the second of a pair that follows.
    uint8_t  teeth;           ///< Teeth of the wheel.
    uint8_t  slot;            ///< Of the last placed edge (searching: of the newest interval) in `memory`.
    uint8_t  level_slot, level_left; ///< The next old interval, and how many are left.
    uint8_t  fault_age;       ///< Searching: edges since one that looked like a fault, up to 255.
    uint8_t  gap_age;         ///< Searching: edges since a gap, up to 3.
    uint8_t  provisional;     ///< Sync came over faults: a mark that contradicts ends it.
    uint8_t  unlearned;       ///< Teeth to go until the memory knows a whole revolution.
    uint8_t  now;             ///< Index of the present clocks.
    uint8_t  odd_periods;     ///< Even periods in a row that disagree with the leading clock.
    uint8_t  mode;            ///< Waiting, searching, synced (sd_crank_parts.h).
    uint8_t  position;        ///< Of the last placed edge.
    uint8_t  revolution;      ///< 0 or 1, meaningful with phase_votes at its limit.
    uint8_t  pending_mark;    ///< Mark whose vote is due, or SD_CRANK_MARKS_MAX.
    int8_t   suspected_slip;  ///< Slip that the last vote found but had no reason to believe.
    uint8_t  missed;          ///< Marks missed in a row while synced.
    uint8_t  rejected;        ///< Edges left out in a row.
    uint8_t  mark_clean;      ///< The pending mark was passed with both teeth beside it and nothing between.
    uint8_t  unsure;          ///< The angle may have slipped; until the next vote no tooth is valid.
    uint8_t  doubtful;        ///< The last placed edge was coasted to or far off.
    uint8_t  search_marks;    ///< Marks that the search counts a revolution, two with one tooth between as one; in bit 4 + m: such a
                              ///< pair follows mark m.
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

/// True when the phase is set, and sd_tooth_t.cycle_position counts from the right revolution.
bool sd_crank_phase_known(const sd_crank_t *self);

/// Tells the time. Returns true when this call found the engine stalled: sync and phase are gone.
bool sd_crank_poll(sd_crank_t *self, uint32_t tick);

/// Edges were lost on their way here: angle and phase are unknown, and sought afresh from the next edge on.
void sd_crank_lose_sync(sd_crank_t *self);

/// Changes config.stall_ticks; the angle stays. SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_crank_set_stall(sd_crank_t *self, uint32_t stall_ticks);

/// How the crank turns.
typedef struct sd_crank_motion {
    float speed_radps;         ///< Over tooth->period_ticks; 0 when there is no period.
    float acceleration_radps2; ///< From the leading clock; 0 when there is no period.
} sd_crank_motion_t;

/// At the last decoded edge, which *tooth is of. tick_hz: capture ticks a second, > 0.
sd_crank_motion_t sd_crank_motion_of(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz);

/// One of them alone.
static inline float sd_crank_speed_radps(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz) {
    return sd_crank_motion_of(self, tooth, tick_hz).speed_radps;
}
static inline float sd_crank_acceleration_radps2(const sd_crank_t *self, const sd_tooth_t *tooth, float tick_hz) {
    return sd_crank_motion_of(self, tooth, tick_hz).acceleration_radps2;
}

#ifdef __cplusplus
}
#endif

#endif
