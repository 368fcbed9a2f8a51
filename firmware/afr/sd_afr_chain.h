/* SPDX-License-Identifier: MIT */
/// sd_afr_chain.h - composition of every cylinder's gas by the chain of document 004, Figure 13:
///
///     measured -> D, sensor inverted (sd_uego.h) -----------------> air fraction u -> A, observer (sd_afr_observer.h)
///     B, manifold -> C, delay (sd_exhaust.h) -> M, D_i, outflow as the sensor meets them -^
///
/// The chain has no covariance. What it says of its own scatter is measured: cylinders' deviations from the mean change
/// from cycle to cycle, and three times the mean square of that, over some 8 cycles, stands for their variance. It holds
/// noise and whatever still moves; of a bias only what is usual beside such noise (docs/theory/afr.md).
///
/// B and C are stepped by the caller, as for the joint filter (sd_afr_joint.h), and so serve whoever else reads them; their
/// delay includes SD_UEGO_LEAD. Two variants from one body: _f32 and _q31. Real-time contract: no heap, no globals, no libm;
/// set divides, once a cycle. Sines as in sd_uego.h, read in place. One writer per state.
#ifndef SD_AFR_CHAIN_H
#define SD_AFR_CHAIN_H
#include "sd_afr_observer.h"
#include "sd_uego.h"

#ifdef __cplusplus
extern "C" {
#endif

/// All cylinders, by firing order, at one time. 0 while there is no estimate.
typedef struct sd_afr_estimate {
    float lambda[SD_AFR_CYLINDERS_MAX]; ///< 1 - a of each cylinder.
    float deviation[SD_AFR_CYLINDERS_MAX]; ///< From the mean, over the mean.
    float sd[SD_AFR_CYLINDERS_MAX];        ///< What the deviation may be off by (standard deviation): the filter's, or what the chain
                                           ///< scatters by, and what delay and lags may be off by.
} sd_afr_estimate_t;

/// Read by init only.
typedef struct sd_afr_chain_config {
    uint16_t cycle_positions;               ///< As in sd_uego_config_t.
    uint8_t  cylinders;                     ///< 1 to SD_AFR_CYLINDERS_MAX.
    uint8_t  harmonics;                     ///< n_h of D, 1 to SD_UEGO_HARMONICS_MAX: half the cylinders, more is noise.
    uint16_t settle_steps;                  ///< Positions until the estimate counts as converged, any.
    float    tau1_s, tau2_s;                ///< The sensor's lags, each [1e-4, 1].
    float    gain_air, gain_cylinder;       ///< A: L2 (0, 2) and L_cyl (0, 100].
    float    inversion_gain, inversion_floor; ///< D, Fourier form: g (0, 0.1] and rho [0.01, 1].
} sd_afr_chain_config_t;

/// State and functions of the chain in one number type: N is f32 or q31, T its type.
#define SD_AFR_CHAIN_DECLARE(N, T)                                                                                     \
    typedef struct sd_afr_chain_##N {                                                                                  \
        sd_uego_##N##_t uego;                        /* D */                                                           \
        sd_afr_observer_##N##_t observer;            /* A */                                                           \
        sd_real_##N##_t last[SD_AFR_CYLINDERS_MAX];  /* deviations a cycle ago */                                      \
        sd_real_##N##_t change_square;               /* of them in a cycle, mean */                                    \
        uint8_t  cycles;                             /* that are in it, up to 8 */                                     \
    } sd_afr_chain_##N##_t;                                                                                            \
    /* SD_OK if init takes it, else SD_ERR_CONFIG. */                                                                  \
    sd_result_t sd_afr_chain_check_##N(const sd_afr_chain_config_t *config);                                           \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. */                                                            \
    sd_result_t sd_afr_chain_init_##N(sd_afr_chain_##N##_t *self, const sd_afr_chain_config_t *config);                \
    /* Once a cycle. Duration of a position, (0, 0.1] s; gains: oscillator form of D, NULL: Fourier form; */           \
    /* charge: one cylinder's gas in one cycle over mass_base, (0, 1). What is outside keeps its last value. */     \
    void sd_afr_chain_set_##N(sd_afr_chain_##N##_t *self, const int32_t *sine_q31, float step_s,                       \
                              const sd_uego_gains_t *gains, T charge);                                          \
    /* The next sample begins anew, all cylinders alike. */                                                            \
    void sd_afr_chain_restart_##N(sd_afr_chain_##N##_t *self);                                                         \
    /* Next position. measured: air fraction, mean of the samples within the position; anything outside (-1, 1) */     \
    /* (NaN too) counts as no sample. */                                                                               \
    void sd_afr_chain_step_##N(sd_afr_chain_##N##_t *self, const int32_t *sine_q31, const sd_exhaust_now_##N##_t *now, \
                               uint32_t cycle_position, T measured);                                                   \
    /* A cylinder's lambda is known to have changed by this much: its fuel was trimmed. Beyond +-1, or NaN: ignored. */\
    void sd_afr_chain_move_##N(sd_afr_chain_##N##_t *self, uint32_t cylinder, float lambda_change);                    \
    /* lambda = 1 - a of a cylinder, by firing order; 0 beyond, or while not running. */                               \
    float sd_afr_chain_lambda_##N(const sd_afr_chain_##N##_t *self, uint32_t cylinder);                                \
    /* Their mean; 0 while not running. */                                                                             \
    sd_real_##N##_t sd_afr_chain_mean_##N(const sd_afr_chain_##N##_t *self);                                           \
    /* All of them in one pass. */                                                                                     \
    void sd_afr_chain_read_##N(const sd_afr_chain_##N##_t *self, sd_afr_estimate_t *out);                              \
    /* Of a cylinder's lambda less the mean of all, from its own scatter; large at a start. */                         \
    float sd_afr_chain_deviation_variance_##N(const sd_afr_chain_##N##_t *self);                                       \
    /* Invalid until the first sample, degraded while it converges. innovation: of the sensor, air fraction. */        \
    sd_status_t sd_afr_chain_status_##N(const sd_afr_chain_##N##_t *self);

SD_AFR_CHAIN_DECLARE(f32, float)
SD_AFR_CHAIN_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
