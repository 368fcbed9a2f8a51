/* SPDX-License-Identifier: MIT */
/// sd_driveline_hybrid.h - the hybrid observer of A. Balluchi and others, "A hybrid observer for the driveline dynamics" (document
/// 003): which location the driveline is in from residuals, and its state by an observer that switches with the location.
///
/// Three residual generators, one a location, and three continuous observers of which the location's is stepped:
///     z_j' = H_j z_j + E_j + B u + L_j y,   r_j = C z_j - y,   location j fits while |r_j| <= threshold      (6) to (8)
///     x'   = F_q x + E_q + B u + G_q y                                                                       (15)
/// u: engine torque less that of the equilibrium, N m; y: crank speed less that of the equilibrium, rpm; x: torsion, rad, crank and
/// wheel speed, rad/s, all less the equilibrium. u is held over a step at its mean, y is straight between two steps.
/// Identification: the location q is left when its residual is above the threshold, for a neighbour (1-2, 2-3) whose residual is below
/// half of it. A residual says nothing until the one change of location has died out of it: none is left before its own residual has fitted
/// for calm_s, or hold_s have gone by. Locations 1 and 3 obey the same matrices and differ by a constant, so that their residuals are the
/// same in the end: from 2 the torsion of the continuous observer says which.
///
/// It is here as the reference: it wants a speed without noise, and tooth times are not that (docs/driveline.md). Use sd_driveline_guard.h.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers; tables are
/// read only. Call order: init; step every tables.period_s.
#ifndef SD_DRIVELINE_HYBRID_H
#define SD_DRIVELINE_HYBRID_H
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_DRIVELINE_LOCATIONS 3

/// One observer over one step: x <- by_state x + constant + by_torque u + by_speed[0] (last y) + by_speed[1] (y).
typedef struct sd_driveline_map {
    float by_state[3][3];
    float constant[3];
    float by_torque[3], by_speed[2][3];
} sd_driveline_map_t;

typedef struct sd_driveline_bank {
    float    period_s;       ///< Of a step, (0, 1].
    float    threshold_rpm;  ///< Of a residual, (0, 1e4].
    float    rpm_per_radps;  ///< 30/pi.
    float    middle_rad;     ///< Torsion 0 less that of the equilibrium: where location 1's side begins.
    float    hold_s, calm_s; ///< After a change: the longest that a residual takes to die out; for how long it must have fitted, [0, 10].
    float    settle_s;       ///< After init, until the estimate counts, [0, 100].
    sd_driveline_map_t residual[SD_DRIVELINE_LOCATIONS], observer[SD_DRIVELINE_LOCATIONS];
} sd_driveline_bank_t;

typedef struct sd_driveline_hybrid {
    float    z[SD_DRIVELINE_LOCATIONS][3]; ///< Of the residual generators.
    float    x[3];                         ///< Of the continuous observer.
    float    last_speed_rpm;
    float    run_s;      ///< Since init, as far as settle_s.
    float    since_s, calm_s; ///< Since the location changed; since its residual last did not fit.
    uint16_t rejected;   ///< Steps left out, saturating.
    uint8_t  location;   ///< 1 to 3.
    uint8_t  begun, may_leave;
} sd_driveline_hybrid_t;

typedef struct sd_driveline_hybrid_out {
    float    x[3];       ///< Torsion, rad, crank and wheel speed, rad/s, less the equilibrium.
    float    residual_rpm[SD_DRIVELINE_LOCATIONS];
    uint8_t  fits[SD_DRIVELINE_LOCATIONS]; ///< 1: |residual| <= threshold.
    uint8_t  location;   ///< 1 to 3.
    uint8_t  changed;    ///< 1: at this step.
    sd_status_t status;  ///< innovation: the residual of the location, rpm. Degraded while no location fits.
} sd_driveline_hybrid_out_t;

/// Begins in a location, 1 to 3, in equilibrium. SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_driveline_hybrid_init(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, uint8_t location);
/// A period later: the torque's mean over it, and the speed at its end. A torque or speed that is not within +-1e6 is left out: everything
/// holds, and the status says so.
void sd_driveline_hybrid_step(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, float torque_nm, float speed_rpm,
                              sd_driveline_hybrid_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
