/* SPDX-License-Identifier: MIT */
/// sd_uego.h - what the wideband sensor meets, from what it says: block D of document 004, Figure 13.
///
/// The gas at the tip repeats every cycle: u = Re sum over k = 0..n_h of c_k E_k, E_k = exp(j k alpha/2); the sensor is
/// two lags, each stepped s += m (input - s), m = 1 - exp(-step/tau). Both forms correct c_k += G_k conj(E_k) (y - yhat):
///   Fourier (the document's adaptive law):  yhat = Re sum of c_k H_k E_k,  G_k = g conj(H_k)/(|H_k|^2 + rho^2),
///     H_k the steady response of the two: the product of m/(1 - (1 - m) exp(-j k 2 pi/positions))
///   oscillator: yhat = s1 of the two lags run on u, corrected too; all gains constant, from a Riccati equation
/// n_h of half the cylinders holds every pattern that cylinders can make. Air fractions, (-1, 1).
///
/// Each lag takes its input from the end of a position for all of it and so leads by half a position; a reading that is the
/// mean over a position lags by half. So u is the gas of SD_UEGO_LEAD positions ago, which the caller adds to his delay.
///
/// Sines are read where the caller keeps them, sine_q31[k] = sin(2 pi k / cycle_positions) 2^31, saturated.
/// Two variants from one body: _f32 and _q31. Real-time contract: no heap, no globals, no libm; n_h passes a step; set
/// divides, once a cycle. One writer per state.
#ifndef SD_UEGO_H
#define SD_UEGO_H
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_UEGO_HARMONICS_MAX 4   ///< Harmonics of the cycle that the inverted sensor follows.
#define SD_UEGO_POSITIONS_MAX 240 ///< Wheel positions in a cycle.
#define SD_UEGO_LEAD          1.5f /* positions */

/// Gains of the oscillator form at one speed.
typedef struct sd_uego_gains {
    float re[SD_UEGO_HARMONICS_MAX + 1], im[SD_UEGO_HARMONICS_MAX + 1]; ///< Gain G_k of each harmonic, real and imaginary part; im[0] is
                                                                        ///< not read.
    float lag2, lag1; ///< Gains of s2 and s1.
} sd_uego_gains_t;

/// Read by init only.
typedef struct sd_uego_config {
    uint16_t cycle_positions; ///< 24 to SD_UEGO_POSITIONS_MAX, a multiple of 4.
    uint8_t  harmonics;       ///< n_h of the cycle, 1 to SD_UEGO_HARMONICS_MAX.
    float    tau1_s, tau2_s;  ///< The sensor's lags, each [1e-4, 1].
    float    gain, floor;     ///< g (0, 0.1] and rho [0.01, 1] of the Fourier form.
} sd_uego_config_t;

/// State and functions of the inverted sensor in one number type: N is f32 or q31, T its type.
#define SD_UEGO_DECLARE(N, T)                                                                                          \
    typedef struct sd_uego_##N {                                                                                       \
        T re[SD_UEGO_HARMONICS_MAX + 1], im[SD_UEGO_HARMONICS_MAX + 1];     /* c_k */                                  \
        T h_re[SD_UEGO_HARMONICS_MAX + 1], h_im[SD_UEGO_HARMONICS_MAX + 1]; /* H_k */                                  \
        T lag2, lag1, innovation;                                                                                      \
        sd_gain_##N##_t g_re[SD_UEGO_HARMONICS_MAX + 1], g_im[SD_UEGO_HARMONICS_MAX + 1], g_lag2, g_lag1;              \
        sd_gain_##N##_t move2, move1;               /* 1 - exp(-step/tau) */                                           \
        float    tau1_s, tau2_s, gain, floor;                                                                          \
        uint16_t cycle_positions;                                                                                      \
        uint8_t  harmonics, oscillator, running;                                                                       \
    } sd_uego_##N##_t;                                                                                                 \
    /* SD_OK if init takes it, else SD_ERR_CONFIG. */                                                                  \
    sd_result_t sd_uego_check_##N(const sd_uego_config_t *config);                                                     \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. */                                                            \
    sd_result_t sd_uego_init_##N(sd_uego_##N##_t *self, const sd_uego_config_t *config);                               \
    /* Duration of a position, (0, 0.1] s, ignored outside; gains: oscillator form, NULL: Fourier form. */             \
    void sd_uego_set_##N(sd_uego_##N##_t *self, const int32_t *sine_q31, float step_s, const sd_uego_gains_t *gains);   \
    /* The next sample begins anew. */                                                                                 \
    void sd_uego_restart_##N(sd_uego_##N##_t *self);                                                                   \
    /* Position with the measured air fraction; anything outside (-1, 1) counts as not measured. Returns u. */         \
    T sd_uego_step_##N(sd_uego_##N##_t *self, const int32_t *sine_q31, uint32_t cycle_position, T measured);

SD_UEGO_DECLARE(f32, float)
SD_UEGO_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
