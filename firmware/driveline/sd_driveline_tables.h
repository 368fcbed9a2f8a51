/* SPDX-License-Identifier: MIT */
/// sd_driveline_tables.h - what the observers know of a driveline; made on the host (host_sim/design/driveline), read in place.
#ifndef SD_DRIVELINE_TABLES_H
#define SD_DRIVELINE_TABLES_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_DRIVELINE_GEARS_MAX 8 ///< Forward gears.
#define SD_DRIVELINE_OCTAVES   9 ///< Gains stand an octave of time apart, straight between.

/// States of the filter, in this order.
typedef enum sd_driveline_state {
    SD_DRIVELINE_PHASE,       ///< Crank angle less the nominal place of the last tooth, rad.
    SD_DRIVELINE_SPEED,       ///< Of the crank, rad/s.
    SD_DRIVELINE_TWIST,       ///< rad, at the wheels.
    SD_DRIVELINE_WHEEL,       ///< Speed of the wheels, rad/s.
    SD_DRIVELINE_BIAS,        ///< N m at the crank.
    SD_DRIVELINE_WHEEL_PHASE, ///< Angle of the wheels less the place of their last edge, rad.
    SD_DRIVELINE_STATES       ///< Their number.
} sd_driveline_state_t;

/// What decides on the location.
typedef enum sd_driveline_guard_by {
    SD_GUARD_ANGLE  = 0, ///< The torsion: trusts the shaft's stiffness.
    SD_GUARD_TORQUE = 1, ///< The torque through the shaft: trusts the engine's torque.
} sd_driveline_guard_by_t;

/// Corrections for one radian of lateness, by state.
typedef struct sd_driveline_gain {
    float of[SD_DRIVELINE_STATES]; ///< Unit of the state per rad.
} sd_driveline_gain_t;

#define SD_DRIVELINE_LOCATIONS 3 ///< Of the shaft: torn one way, within its play, torn the other way.

/// One of document 003's observers (sd_driveline_hybrid.h) over one step:
/// x <- by_state x + constant + by_torque u + by_road d + by_speed[0] (last y) + by_speed[1] (y).
typedef struct sd_driveline_map {
    float by_state[3][3]; ///< Unit of a state over unit of a state: rad and rad/s.
    float constant[3];    ///< Units of the states.
    float by_torque[3], by_road[3], by_speed[2][3]; ///< Units of the states per N m, N m and rpm.
} sd_driveline_map_t;

/// Document 003's observers of one gear.
typedef struct sd_driveline_bank {
    float    period_s;       ///< Of a step, (0, 1].
    float    threshold_rpm;  ///< Of a residual, (0, 1e4].
    float    rpm_per_radps;  ///< 30/pi.
    float    middle_rad;     ///< Torsion 0 less that of the equilibrium: where location 1's side begins.
    float    hold_s, calm_s; ///< After a change: the longest that a residual takes to die out; for how long it must have fitted, [0, 10].
    float    settle_s;       ///< After init, until the estimate counts, [0, 100].
    float    ratio;          ///< Of the wheels' speed over the crank's, where speeds are not less an equilibrium's; 0: they are.
    sd_driveline_map_t residual[SD_DRIVELINE_LOCATIONS], observer[SD_DRIVELINE_LOCATIONS];
} sd_driveline_bank_t;

/// What the observers need of a gear.
typedef struct sd_driveline_gear {
    float ratio; ///< Speed of the wheels over that of the crank, (0, 2].
    /// [0: soft, 1: stiff][octave], for steps of shortest_s 2^octave.
    sd_driveline_gain_t tooth[2][SD_DRIVELINE_OCTAVES], wheel[2][SD_DRIVELINE_OCTAVES];
    sd_driveline_gain_t start[2][SD_DRIVELINE_OCTAVES]; ///< Of teeth while the filter settles: they trust the state less.
    sd_driveline_bank_t bank; ///< Of document 003's observers; the guard filter does not read it.
} sd_driveline_gear_t;

/// Part of the calibration page, read only.
typedef struct sd_driveline_tables {
    float    tick_s;            ///< Of the capture timer, (0, 1e-3].
    float    pitch_rad;         ///< A position of the crank's wheel, (0, 0.6].
    float    wheel_pitch_rad;   ///< A position of the wheels' teeth; 0: there are none.
    float    shortest_s;        ///< Step of the first octave, (0, 1].
    float    per_inertia;       ///< 1/Je, 1/(kg m2), (0, 1e4].
    float    viscous_nms;       ///< Be, [0, 100].
    float    per_vehicle;       ///< 1/Jv, (0, 1e4].
    float    soft_nmprad, stiff_nmprad; ///< Stiffness, [0, 1e7].
    float    damping_nms;       ///< [0, 1e6].
    float    kink_rad;          ///< (0, 1].
    float    rolling_nm;        ///< Resistance of the road at the wheels, [0, 1e5].
    float    drag_nms2;         ///< Of the air, [0, 1e4].
    float    reject_rad;        ///< Lateness of a tooth beyond which it is left out, (0, 1].
    float    per_reject;        ///< 1/reject_rad, [1, 1e9].
    float    doubt_rad;         ///< Mean lateness of some 16 teeth beyond which the estimate is not believed, (0, 1].
    float    settle_s;          ///< Time in a gear until the estimate counts, [0, 100].
    float    moving_radps;      ///< Rate of torsion above which the driveline counts as moving, [0, 1e6].
    float    moving_hold_s;     ///< For how long after that it still does, [0, 100].
    uint8_t  gears;             ///< 0: no tables.
    uint8_t  guard;             ///< sd_driveline_guard_by_t.
    sd_driveline_gear_t gear[SD_DRIVELINE_GEARS_MAX]; ///< The first `gears`.
} sd_driveline_tables_t;

/// Whether every number is in the range said above. NaN is in none.
bool sd_driveline_tables_ok(const sd_driveline_tables_t *tables);

#ifdef __cplusplus
}
#endif
#endif
