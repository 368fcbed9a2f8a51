/* SPDX-License-Identifier: MIT */
/// sd_work.h - work of a cycle from the crank's kinetic energy at the same teeth, a cycle apart.
///
/// A window is a stretch of teeth behind a firing, where the crank has taken up the firing's work and the next one has hardly begun. The
/// wheel takes T ticks for it in this cycle and T' in the last one. With k = J (span)^2/2 (ticks a second)^2, J such that a crank of
/// constant energy takes as long,
///     E = k / T^2        work = E - E' = E r (2 - r),   r = (T' - T) / T'
/// is what the crank has gained since: the work of the gas in all cylinders over those 720 deg less the work of load and friction.
/// The same teeth pass both times, so that their own errors, the inertia's course over the angle, the reciprocating masses and the
/// motored torque cancel; no pulse, no tooth pattern and no fit goes in. The differences T' - T are exact, since times are counted.
///
/// What it cannot say: the level (load and friction are not known, so that steady running gives 0), and, of one cycle alone, the work of
/// one cylinder. The difference of two windows in a row is how much more work the later firing did than the same cylinder's firing a cycle
/// before; that is one cylinder's only where firings are far enough apart (`own`).
///
/// Its error: the inertia is a factor. Each end of the window has the edges' error, so sd = 4 E sqrt((edge/span)^2 + timer^2/T^2), with
/// timer = 1/sqrt(12) for rounding; what of a firing is done outside of its window is not in it. A difference of windows has sqrt(2) times
/// as much.
///
/// Real-time contract: no heap, no globals, no libm; constant time but at a restart. One writer. Call order: restart; for each placed tooth
/// sd_work_passes, and where that is true sd_work_edge, and where that is true sd_work_read_f32 or sd_work_read_q31.
#ifndef SD_WORK_H
#define SD_WORK_H
#include <stdbool.h>
#include <stdint.h>

#include "sd_limits.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_WORK_WINDOWS_MAX SD_CYLINDERS_MAX ///< Windows of a cycle.

/// The window of one firing. It lies between two teeth that are there; windows do not overlap and come in firing order.
typedef struct sd_work_window {
    float    energy_jticks2; ///< k, energy times the square of the ticks that the window takes, [1e-6, 1e30] J.
    float    span_rad;       ///< Crank angle from its first tooth to its last, [0.05, 12.5].
    uint16_t first;          ///< Cycle position of its first tooth, below 2 positions.
    uint16_t last;           ///< Cycle position of its last tooth, below 2 positions.
} sd_work_window_t;

/// Read only. Tables of one engine and wheel.
typedef struct sd_work_tables {
    sd_work_window_t window[SD_WORK_WINDOWS_MAX]; ///< By firing order.
    uint16_t cycle;    ///< Positions of a cycle, twice the wheel's, 24 to 240.
    uint8_t  windows;  ///< As many as firings; 0: the engine has none, and nothing is said.
    uint8_t  own;      ///< Bit i: window i less the one before holds the work of firing i, and at most a tenth of another's.
    uint8_t  alike;    ///< 1: the windows repeat after a revolution, so that they are placed well without a phase.
    uint8_t  reserved[3]; ///< 0 to fill the word; not read.
} sd_work_tables_t;

/// All zero is no valid start: sd_work_restart makes one.
typedef struct sd_work_meter {
    uint32_t begin_tick;  ///< Of the first tooth of the window under way.
    uint32_t ticks;       ///< T of the window that ended last.
    uint32_t last_ticks;  ///< T' of that window.
    uint32_t passed_ticks[SD_WORK_WINDOWS_MAX]; ///< T of each window when it passed last.
    float    work_j;      ///< Of the window that ended last, as read; of no meaning before.
    uint16_t waits;       ///< Cycle position of the tooth that is waited for; UINT16_MAX: of none.
    uint8_t  at;          ///< Window that is waited for, or under way.
    uint8_t  stage;       ///< sd_work_stage_t.
    uint8_t  seen;        ///< Bit i: passed_ticks[i] is of the cycle before.
    uint8_t  known;       ///< 1: work_j is of the window before the one under way.
} sd_work_meter_t;

/// What the end of a window says.
typedef struct sd_work_out {
    float   work_j;       ///< Energy gained over 720 deg, J, positive where the crank became faster; 0 where not known.
    float   change_j;     ///< That less the one of the firing before, J; 0 where not known.
    float   sd_j;         ///< Standard deviation of work_j from errors of the tooth times, J; 0 where not known.
    uint8_t firing;       ///< Index in firing order.
    uint8_t known;        ///< 1: work_j and sd_j.
    uint8_t change_known; ///< 1: change_j, and it is the firing's own.
} sd_work_out_t;

/// Whether every field is in its range.
bool sd_work_tables_ok(const sd_work_tables_t *tables);

/// The angle is new, and a tooth at `cycle_position` has passed: what was seen before is forgotten, and the next window is waited for.
void sd_work_restart(sd_work_meter_t *self, const sd_work_tables_t *tables, uint32_t cycle_position);

/// Whether the tooth that is waited for has come, or was passed over. advance: positions since the last tooth, 1 or more.
static inline bool sd_work_passes(const sd_work_meter_t *self, const sd_work_tables_t *tables, uint32_t cycle_position, uint32_t advance) {
    const uint32_t waits = self->waits, past = cycle_position - waits;
    return ((cycle_position < waits) ? past + tables->cycle : past) < advance;
}

/// The tooth that is waited for has come at `tick`, or was passed over: another position. trusted: 1 when the decoder is sure of it. True
/// when a window has ended: then read what it says.
bool sd_work_edge(sd_work_meter_t *self, const sd_work_tables_t *tables, uint32_t cycle_position, uint32_t tick, uint8_t trusted);

/// What the window that has just ended says, in single precision or by integers alone. edge_rad: random error of an edge, [0, 0.02] rad.
/// Call it once a window: it keeps the work for the next change.
void sd_work_read_f32(sd_work_meter_t *self, const sd_work_tables_t *tables, float edge_rad, sd_work_out_t *out);
void sd_work_read_q31(sd_work_meter_t *self, const sd_work_tables_t *tables, float edge_rad, sd_work_out_t *out);

#ifdef __cplusplus
}
#endif

#endif
