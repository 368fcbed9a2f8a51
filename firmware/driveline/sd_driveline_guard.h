/* SPDX-License-Identifier: MIT */
/// sd_driveline_guard.h - torsion of the driveline from crank teeth: a Kalman filter that knows where the shaft becomes stiff.
///
/// The shaft between engine and wheels is soft about its middle and stiff beyond a torsion of kink_rad either way; which of the
/// three, its location, is 1 (backward, stiff), 2 (soft), 3 (forward, stiff). The filter carries the crank's phase and speed, torsion,
/// speed of the wheels, and by how much the torque that it is told of is wrong:
///     Je speed' = torque + bias - Be speed - ratio S,   twist' = ratio speed - wheel,   Jv wheel' = S - road(wheel),
///     S = spring(twist) + damping twist'
/// It steps from tooth to tooth by the midpoint rule, and is corrected by how late the tooth comes, which is white where a period's
/// error is not. Location is where its own torsion stands: no residual has to grow first. Gains are those of the steady filter of the
/// location, for the time that the step took.
/// Where the mean lateness of some 16 teeth is beyond doubt_rad, the filter is not where it believes to be, and settles anew: it says
/// converging. With wheel teeth it carries the wheels' phase too, and an edge of theirs corrects all of it.
///
/// Torsion and shaft torque are those at the wheels; "at the crank" says otherwise.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time but for one pass for each position without an edge. One writer
/// per state, which is plain data without pointers. Tables are read only and may stand in flash. Call order: init; step for every placed
/// tooth; wheel for edges of the wheels between them; restart when the angle was lost.
#ifndef SD_DRIVELINE_GUARD_H
#define SD_DRIVELINE_GUARD_H
#include "sd_driveline_tables.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A placed tooth, and what is known of the interval that ends with it.
typedef struct sd_driveline_tooth {
    uint32_t period_ticks; ///< Time since the last placed tooth.
    uint16_t advance;      ///< Positions since the last placed tooth, 1 to 120.
    uint8_t  health;       ///< sd_health_t of the tooth; only those that are SD_VALID correct the filter.
    uint8_t  gear;         ///< 1 to the tables' gears; 0: clutch open, neutral, or not known.
    /// Of the engine at the crank, mean over the interval, friction taken off; not finite or beyond 20000: the last good one holds.
    float    torque_nm;
    float    place_rad;    ///< How far behind its nominal place the tooth stands on the wheel; 0 where the pattern is not known.
    /// How far a crank of constant inertia is ahead of the real one at this tooth, rad. It counts for the tooth's place as place_rad does;
    /// what is said of torsion and location is that of the real crank. 0 where the inertia does not vary.
    float    lead_rad;
} sd_driveline_tooth_t;

/// What is said at a tooth.
typedef struct sd_driveline_out {
    float    twist_rad;    ///< Torsion, at the wheels.
    float    shaft_nm;     ///< Torque of the shaft at the crank: spring and damping, times the ratio.
    float    winding_radps; ///< Rate of the torsion.
    float    wheel_radps;  ///< Speed of the wheels.
    float    bias_nm;      ///< What the torque told is believed to lack.
    uint8_t  location;     ///< 1 to 3; 0: not known.
    uint8_t  changed;      ///< 1: the location is another than at the last tooth.
    uint8_t  moving;       ///< 1: the shaft winds or unwinds faster than the tables' limit, or did within their hold time.
    sd_status_t status;    ///< innovation in rad of the crank.
} sd_driveline_out_t;

typedef struct sd_driveline_guard {
    float    x[SD_DRIVELINE_STATES]; ///< sd_driveline_state_t.
    sd_driveline_gain_t gain; ///< Of the last tooth,
    float    gain_s;       ///< made for so long a step
    float    torque_nm;    ///< Last good one.
    float    mean_late_rad; ///< Mean lateness of some 16 teeth.
    float    settled_s;    ///< Time that the filter has run in this gear.
    float    still_s;      ///< Time since the shaft last moved fast.
    uint16_t rejected;     ///< Teeth left out since init, saturating.
    uint8_t  gear;         ///< Of the last step; 0: it does not run.
    uint8_t  location;
    uint8_t  by_angle;     ///< Location that the torsion stands in.
    uint8_t  table;        ///< from which gains: 1: stiff, and 2: of the start.
    uint8_t  strikes;      ///< Teeth left out in a row.
} sd_driveline_guard_t;

/// Forgets everything. SD_OK, or SD_ERR_CONFIG with the state untouched: a number of the tables is out of its range. Tables without
/// gears are none: the filter rests, and says uncalibrated.
sd_result_t sd_driveline_guard_init(sd_driveline_guard_t *self, const sd_driveline_tables_t *tables);
/// The angle was lost, or a time is missing: the filter begins anew at the next tooth, its bias kept.
void sd_driveline_guard_restart(sd_driveline_guard_t *self);
/// Takes a tooth and fills *out.
void sd_driveline_guard_step(sd_driveline_guard_t *self, const sd_driveline_tables_t *tables, const sd_driveline_tooth_t *tooth,
                             sd_driveline_out_t *out);
/// An edge of the wheels, since_ticks after the last placed tooth, `advance` of their positions after their last edge. Nothing
/// happens while the filter does not run or the tables know no wheel teeth. One that is too far off leaves the wheels' phase to be found
/// anew.
void sd_driveline_guard_wheel(sd_driveline_guard_t *self, const sd_driveline_tables_t *tables, uint32_t since_ticks, uint16_t advance);

#ifdef __cplusplus
}
#endif
#endif
