/* SPDX-License-Identifier: MIT */
/// sd_driveline_hybrid.h - the hybrid observer of A. Balluchi and others, "A hybrid observer for the driveline dynamics" (document
/// 003): which location the driveline is in from residuals, and its state by an observer that switches with the location.
///
/// Three residual generators, one a location, and three continuous observers of which the location's is stepped:
///     z_j' = H_j z_j + E_j + B u + L_j y,   r_j = C z_j - y,   location j fits while |r_j| <= threshold      (6) to (8)
///     x'   = F_q x + E_q + B u + G_q y                                                                       (15)
/// u: engine torque less that of the equilibrium, N m; y: crank speed less that of the equilibrium, rpm; x: torsion, rad, crank and
/// wheel speed, rad/s, all less the equilibrium. u is held over a step at its mean, y is straight between two steps. The road's resistance
/// d, which the document leaves out, adds B_d d to both; the equilibrium may be that of rest, torsion 0 and no torque, and x, u and y are
/// then plain torsion, speeds and torque.
/// Identification: the location q is left when its residual is above the threshold, for a neighbour (1-2, 2-3) whose residual is below
/// half of it. A residual says nothing until the one change of location has died out of it: none is left before its own residual has fitted
/// for calm_s, or hold_s have gone by. Locations 1 and 3 obey the same matrices and differ by a constant, so that their residuals are the
/// same in the end: from 2 the torsion of the continuous observer says which.
///
/// It is here as the reference: it wants a speed without noise, and tooth times are not that
/// (docs/theory/driveline.md). Use sd_driveline_guard.h.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers; tables are
/// read only. Call order: init; step every tables.period_s.
#ifndef SD_DRIVELINE_HYBRID_H
#define SD_DRIVELINE_HYBRID_H
#include "sd_driveline_tables.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// State: plain data, caller-owned, copyable; fields are for logs, write none of them.
typedef struct sd_driveline_hybrid {
    float    z[SD_DRIVELINE_LOCATIONS][3]; ///< States of the residual generators, in the units of x.
    float    x[3];                         ///< Of the continuous observer: torsion, rad, crank and wheel speed, rad/s, less the
                                           ///< equilibrium.
    float    last_speed_rpm;               ///< Measured, at the last step.
    float    run_s;      ///< Since init, as far as settle_s.
    float    since_s, calm_s; ///< Since the location changed; since its residual last did not fit.
    uint16_t rejected;   ///< Steps left out, saturating.
    uint8_t  location;   ///< 1 to 3.
    uint8_t  begun, may_leave; ///< 1: a step was made; the location may change again.
} sd_driveline_hybrid_t;

/// What is said at a step.
typedef struct sd_driveline_hybrid_out {
    float    x[3];       ///< Torsion, rad, crank and wheel speed, rad/s, less the equilibrium.
    float    residual_rpm[SD_DRIVELINE_LOCATIONS]; ///< Of each location.
    uint8_t  fits[SD_DRIVELINE_LOCATIONS]; ///< 1: |residual| <= threshold.
    uint8_t  location;   ///< 1 to 3.
    uint8_t  changed;    ///< 1: at this step.
    sd_status_t status;  ///< innovation: the residual of the location, rpm. Degraded while no location fits.
} sd_driveline_hybrid_out_t;

/// Begins in a location, 1 to 3: in equilibrium, or with bank.ratio above 0 at the torsion 0 and the first step's speed. SD_OK, or
/// SD_ERR_CONFIG with the state untouched: a number of the bank is out of its range.
sd_result_t sd_driveline_hybrid_init(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, uint8_t location);
/// A period later: means over it of the engine's torque and of the road's resistance at the wheels less what the equilibrium has of it, and
/// the speed at its end. A torque or speed that is not within +-1e6 is left out: everything holds, and the status says so.
void sd_driveline_hybrid_step(sd_driveline_hybrid_t *self, const sd_driveline_bank_t *bank, float torque_nm, float road_nm, float speed_rpm,
                              sd_driveline_hybrid_out_t *out);

#ifdef __cplusplus
}
#endif
#endif
