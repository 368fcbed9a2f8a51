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
/// Two variants from one body: _f32 in the units of the names; _q31 per unit of the bases below, for a core without a floating-point
/// unit. Both take the same tables. A step of more than 0.25 s counts as one of 0.25 s in q31, and what leaves its base stays at its end.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time but for one pass for each position without an edge. One writer
/// per state, which is plain data without pointers. Tables are read only and may stand in flash. Call order: init; step for every placed
/// tooth; wheel for edges of the wheels between them; restart when the angle was lost.
#ifndef SD_DRIVELINE_GUARD_H
#define SD_DRIVELINE_GUARD_H
#include "sd_bases.h"
#include "sd_driveline_tables.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Bases of q31, as powers of two.
#define SD_DRIVELINE_PHASE_BITS       0    ///< 1 rad of the crank.
#define SD_DRIVELINE_SPEED_BITS       11   ///< 2048 rad/s of the crank.
#define SD_DRIVELINE_TWIST_BITS       1    ///< 2 rad.
#define SD_DRIVELINE_WHEEL_BITS       9    ///< 512 rad/s of the wheels, and of the rate of torsion.
#define SD_DRIVELINE_TORQUE_BITS      15   ///< 32768 N m at the crank.
#define SD_DRIVELINE_SHAFT_BITS       17   ///< 131072 N m at the wheels.
#define SD_DRIVELINE_WHEEL_PHASE_BITS 3    ///< 8 rad of the wheels.
#define SD_DRIVELINE_STEP_BITS        (-2) ///< 0.25 s, from tooth to tooth.
#define SD_DRIVELINE_TIME_BITS        8    ///< 256 s, of what settles or holds.

/// Of the tables' numbers. Stiffness, damping, viscous friction and ratio are coefficients of sd_bases.h.
#define SD_DRIVELINE_RATIO_BITS       3
#define SD_DRIVELINE_VISCOUS_BITS     9
#define SD_DRIVELINE_STIFFNESS_BITS   21   ///< 2097152 N m/rad.
#define SD_DRIVELINE_DAMPING_BITS     13   ///< 8192 N m s.
#define SD_DRIVELINE_PER_INERTIA_BITS 8    ///< 1/(0.0039 kg m2).
#define SD_DRIVELINE_PER_VEHICLE_BITS (-2) ///< 1/(4 kg m2).
#define SD_DRIVELINE_DRAG_BITS        2    ///< 4 N m s2.
#define SD_DRIVELINE_PER_REJECT_BITS  10   ///< 1/(1 mrad).

/// Numbers of the tables for q31, made by init.
typedef struct sd_driveline_model_q31 {
    uint32_t tick;             ///< Of the capture timer: mantissa, 2^-tick_down of it is a tick's part of a step's base.
    /// As in sd_driveline_tables_t, over the bases above.
    sd_q31_t pitch_rad, wheel_pitch_rad, shortest_s, per_inertia, viscous_nms, per_vehicle, soft_nmprad, stiff_nmprad, damping_nms;
    /// As in sd_driveline_tables_t, over the bases above.
    sd_q31_t kink_rad, rolling_nm, drag_nms2, reject_rad, per_reject, doubt_rad, settle_s, moving_radps, moving_hold_s;
    sd_q31_t ratio;            ///< Of the gear that it runs in.
    uint32_t tick_down;        ///< Binary places that `tick` is shifted down by.
} sd_driveline_model_q31_t;

/// Of tooth, out and state the f32 variant has the units of the names. EXTRA: what only one of the two carries.
#define SD_DRIVELINE_GUARD_DECLARE(N, T, EXTRA)                                                                                            \
    /* A placed tooth, and what is known of the interval that ends with it. */                                                             \
    typedef struct sd_driveline_tooth_##N {                                                                                                \
        uint32_t period_ticks; /* Time since the last placed tooth. */                                                                     \
        uint16_t advance;      /* Positions since the last placed tooth, 1 to 120. */                                                      \
        uint8_t  health;       /* sd_health_t of the tooth; only those that are SD_VALID correct the filter. */                            \
        uint8_t  gear;         /* 1 to the tables' gears; 0: clutch open, neutral, or not known. */                                        \
        /* Of the engine at the crank, mean over the interval, friction taken off; not finite or beyond 20000: the last good one holds. */ \
        T torque_nm;                                                                                                                       \
        T place_rad;           /* How far behind its nominal place the tooth stands on the wheel; 0 where the pattern is not known. */     \
        /* How far a crank of constant inertia is ahead of the real one at this tooth. It counts for the tooth's place as place_rad does;  \
         * what is said of torsion and location is that of the real crank. 0 where the inertia does not vary. */                           \
        T lead_rad;                                                                                                                        \
    } sd_driveline_tooth_##N##_t;                                                                                                          \
    /* What is said at a tooth. */                                                                                                         \
    typedef struct sd_driveline_out_##N {                                                                                                  \
        T twist_rad;           /* Torsion, at the wheels. */                                                                               \
        T shaft_nm;            /* Torque of the shaft at the crank: spring and damping, times the ratio. */                                \
        T winding_radps;       /* Rate of the torsion. */                                                                                  \
        T wheel_radps;         /* Speed of the wheels. */                                                                                  \
        T bias_nm;             /* What the torque told is believed to lack. */                                                             \
        uint8_t location;      /* 1 to 3; 0: not known. */                                                                                 \
        uint8_t changed;       /* 1: the location is another than at the last tooth. */                                                    \
        uint8_t moving;        /* 1: the shaft winds or unwinds faster than the tables' limit, or did within their hold time. */           \
        sd_status_t status;    /* innovation in rad of the crank. */                                                                       \
    } sd_driveline_out_##N##_t;                                                                                                            \
    typedef struct sd_driveline_guard_##N {                                                                                                \
        T x[SD_DRIVELINE_STATES];                   /* sd_driveline_state_t. */                                                            \
        sd_gain_##N##_t gain[SD_DRIVELINE_STATES];  /* Of the last tooth, */                                                               \
        T gain_s;              /* made for so long a step. */                                                                              \
        T torque_nm;           /* Last good one. */                                                                                        \
        T mean_late_rad;       /* Mean lateness of some 16 teeth. */                                                                       \
        T settled_s;           /* Time that the filter has run in this gear. */                                                            \
        T still_s;             /* Time since the shaft last moved fast. */                                                                 \
        EXTRA                                                                                                                              \
        uint16_t rejected;     /* Teeth left out since init, saturating. */                                                                \
        uint8_t gear;          /* Of the last step; 0: it does not run. */                                                                 \
        uint8_t location;                                                                                                                  \
        uint8_t by_angle;      /* Location that the torsion stands in. */                                                                  \
        uint8_t table;         /* From which gains: 1: stiff, and 2: of the start. */                                                      \
        uint8_t strikes;       /* Teeth left out in a row. */                                                                              \
    } sd_driveline_guard_##N##_t;                                                                                                          \
    /* Forgets everything. SD_OK, or SD_ERR_CONFIG with the state untouched: a number of the tables is out of its range, or has no room in \
     * its base. Tables without gears are none: the filter rests, and says uncalibrated. */                                                \
    sd_result_t sd_driveline_guard_init_##N(sd_driveline_guard_##N##_t *self, const sd_driveline_tables_t *tables);                        \
    /* The angle was lost, or a time is missing: the filter begins anew at the next tooth, its bias kept. */                               \
    void sd_driveline_guard_restart_##N(sd_driveline_guard_##N##_t *self);                                                                 \
    /* Takes a tooth and fills *out. */                                                                                                    \
    void sd_driveline_guard_step_##N(sd_driveline_guard_##N##_t *self, const sd_driveline_tables_t *tables,                                \
                                     const sd_driveline_tooth_##N##_t *tooth, sd_driveline_out_##N##_t *out);                              \
    /* An edge of the wheels, since_ticks after the last placed tooth, `advance` of their positions after their last edge. Nothing         \
     * happens while the filter does not run or the tables know no wheel teeth. One that is too far off leaves the wheels' phase to be     \
     * found anew. */                                                                                                                      \
    void sd_driveline_guard_wheel_##N(sd_driveline_guard_##N##_t *self, const sd_driveline_tables_t *tables, uint32_t since_ticks,         \
                                      uint16_t advance);

SD_DRIVELINE_GUARD_DECLARE(f32, float, )
SD_DRIVELINE_GUARD_DECLARE(q31, sd_q31_t, sd_driveline_model_q31_t model;)

#ifdef __cplusplus
}
#endif
#endif
