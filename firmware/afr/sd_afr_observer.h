/* SPDX-License-Identifier: MIT */
/// sd_afr_observer.h - composition of every cylinder's gas from that in the manifold: block A of document 004,
/// equation (9), in air fractions a = 1 - lambda.
///
/// Once a wheel position, for gas masses from sd_exhaust.h (M after the position, D_i and outflow within it) and the
/// air fraction u in the manifold (the sensor inverted, sd_uego.h):
///     x2  += sum over i of a_i D_i - u out         predict the manifold's air first,
///     e    = u M - x2                              then compare: pairing M with the x2 before would inject dM
///     x2  += L2 e
///     a_i += L_cyl share_i e / charge              L_cyl = L_lambda charge^2
/// Converges for L2 and L_cyl that `sixdeg calibrate` tests by the eigenvalues of the error over one cycle; about
/// 0.06 to 0.12 and 2 to 5.
///
/// Two variants from one body: _f32 and _q31. Real-time contract: no heap, no globals, no libm; two passes over the
/// cylinders a step. One writer per state.
#ifndef SD_AFR_OBSERVER_H
#define SD_AFR_OBSERVER_H
#include "sd_exhaust.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Read by init only.
typedef struct sd_afr_observer_config {
    uint8_t  cylinders;      ///< 1 to SD_AFR_CYLINDERS_MAX.
    uint16_t settle_steps;   ///< Positions until the estimate counts as converged, any.
    float    gain_air;       ///< L2, a position, (0, 2).
    float    gain_cylinder;  ///< L_cyl, (0, 100].
} sd_afr_observer_config_t;

/// State and functions of the observer in one number type: N is f32 or q31, T its type.
#define SD_AFR_OBSERVER_DECLARE(N, T)                                                                                  \
    typedef struct sd_afr_observer_##N {                                                                               \
        T air;                                       /* x2, per unit of mass_base */                                   \
        T air_fraction[SD_AFR_CYLINDERS_MAX];        /* a_i, in firing order */                                        \
        T innovation;                                /* e */                                                           \
        sd_gain_##N##_t gain_air, gain_cylinder;     /* L2; L_cyl / charge */                                          \
        float    cylinder_gain;                                                                                        \
        uint16_t steps, settle_steps;                                                                                  \
        uint8_t  cylinders, running;                                                                                   \
    } sd_afr_observer_##N##_t;                                                                                         \
    /* SD_OK if init takes it, else SD_ERR_CONFIG. */                                                                  \
    sd_result_t sd_afr_observer_check_##N(const sd_afr_observer_config_t *config);                                     \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. */                                                            \
    sd_result_t sd_afr_observer_init_##N(sd_afr_observer_##N##_t *self, const sd_afr_observer_config_t *config);       \
    /* charge: one cylinder's gas in one cycle over mass_base, (0, 1); ignored outside. Once a cycle, it divides. */\
    void sd_afr_observer_set_##N(sd_afr_observer_##N##_t *self, T charge);                                      \
    /* The next step begins anew from its own air fraction, all cylinders alike. */                                    \
    void sd_afr_observer_restart_##N(sd_afr_observer_##N##_t *self);                                                   \
    /* Next position; air_fraction in (-1, 1), anything else (NaN too) is left out. */                                 \
    void sd_afr_observer_step_##N(sd_afr_observer_##N##_t *self, const sd_exhaust_now_##N##_t *now, T air_fraction);   \
    /* lambda = 1 - a of a cylinder, by firing order; 0 beyond. */                                                     \
    float sd_afr_observer_lambda_##N(const sd_afr_observer_##N##_t *self, uint32_t cylinder);                          \
    sd_status_t sd_afr_observer_status_##N(const sd_afr_observer_##N##_t *self);

SD_AFR_OBSERVER_DECLARE(f32, float)
SD_AFR_OBSERVER_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
