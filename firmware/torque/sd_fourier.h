/* SPDX-License-Identifier: MIT */
/// sd_fourier.h - adaptive Fourier torque observer (document 004, section 3.2, equations (2) to (4)).
///
/// The kinetic energy phi = J(alpha) omega^2 / 2 changes over crank angle by the mass torque,
///     dphi/dalpha = T_mass(alpha) = T_combustion - T_load*,
/// and T_mass repeats every cycle, so it is a Fourier series in alpha / 2 with n_h harmonics:
///     T_mass = a_0 + sum over i of a_i cos(i alpha / 2) + b_i sin(i alpha / 2) = sum over j of c_j f_j(alpha).
/// At each tooth the observer corrects, then predicts with the corrected coefficients (form B of docs/theory/torque.md):
///     e      = phi - E,  E = J(alpha_k - d/2) omega^2 / 2     omega from the last tooth period, so it belongs
///     phi   -= d L_ke e                                       to the middle of that interval
///     c_j   -= d l_j f_j(alpha_k) e,  l_0 = L_a0,  l of a_i and b_i = i L_ref
///     phi   += d sum of c_j f_j(alpha_k)                      from alpha_k - d/2 to alpha_k + d/2
/// d is the tooth pitch. It is stable for L_ref < 2 / (n_h (n_h + 1)) ((2/d)(2/d - L_ke) - L_a0) (the document's
/// equation (5) is a misprint; derivation in docs/theory/torque.md). Where teeth are missing it only predicts.
///
/// Two variants from one body: _f32 and _q31. Real-time contract: no heap, no globals, no libm; one step costs n_h passes of a
/// loop per tooth position passed, instructions in docs/theory/torque.md; one writer per state. Call order: init; step for every placed
/// tooth; restart after lost sync or a stall; read whenever wanted.
#ifndef SD_FOURIER_H
#define SD_FOURIER_H
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_FOURIER_HARMONICS_MAX 12  ///< Harmonics of the cycle.
#define SD_FOURIER_POSITIONS_MAX 120 ///< Wheel positions a revolution.

/// SI units; read by init only, need not outlive it.
typedef struct sd_fourier_config {
    uint8_t  positions;        ///< Wheel positions a revolution N, 12 to 120; tooth pitch d = 2 pi / N.
    uint8_t  harmonics;        ///< n_h, 1 to 12.
    float    gain_energy;      ///< L_ke, 1/rad, (0, 2/d).
    float    gain_mean;        ///< L_a0, 1/rad^2, > 0.
    float    gain_reference;   ///< L_ref, 1/rad^2, > 0 and below the limit above.
    float    reject_energy;    ///< |e| / E beyond which a tooth is left out, (0, 1]; 1 leaves out hardly any.
    uint16_t settle_steps;     ///< Teeth until the estimate counts as converged, any number.
    float    tick_hz;          ///< Capture ticks a second, [1e5, 2e8].
    float    speed_base_radps; ///< Highest speed, (0, 2000]; per-unit base of q31.
    float    torque_base_nm;   ///< Highest |coefficient| and |torque|, (0, 20000]; per-unit base of q31.
} sd_fourier_config_t;

/// Read only, and used where they stand: on a target that is flash. Both variants take the same.
typedef struct sd_fourier_tables {
    float   inertia_base_kgm2;                      ///< Largest J, (0, 10].
    /// [positions]: J half a pitch before each position over the largest, (0, 1], times 2^31, saturated.
    int32_t inertia_q31[SD_FOURIER_POSITIONS_MAX];
    /// [2 positions]: sin(pi k / positions) 2^31, saturated, each within 4e-6 below 1; periodic over the cycle.
    int32_t sine_q31[2 * SD_FOURIER_POSITIONS_MAX];
} sd_fourier_tables_t;

/// What the observer knows.
typedef struct sd_fourier_estimate {
    float torque_nm;       ///< T_mass at the last tooth: combustion torque less load and friction.
    float mean_nm;         ///< a_0.
    float energy_j;        ///< phi half a pitch after the last tooth.
    float coefficient_nm[2 * SD_FOURIER_HARMONICS_MAX + 1]; ///< a_0, a_1, b_1, a_2, b_2 ...; 0 beyond n_h.
    sd_status_t status;    ///< innovation in J.
} sd_fourier_estimate_t;

/// One variant: T is its number type. State first, then what init derived. Plain data, caller-owned.
#define SD_FOURIER_DECLARE(N, T)                                                                                       \
    typedef struct sd_fourier_##N {                                                                                    \
        T energy;                                         /* phi, per unit of energy_base_j */                         \
        T coefficient[2 * SD_FOURIER_HARMONICS_MAX + 1];  /* per unit of torque_base_nm */                             \
        T torque;                                         /* at the last tooth */                                      \
        T innovation;                                     /* -e of the last corrected tooth */                         \
        T limit;                                          /* of |e| for the last tooth that could correct */           \
        uint16_t steps;                                   /* since restart, saturating */                              \
        uint16_t rejected, rejected_in_row;                                                                            \
        uint8_t  running;                                                                                              \
        uint8_t  harmonics;                                                                                            \
        uint16_t positions, settle_steps;                                                                              \
        uint32_t period_base_ticks;                       /* tooth period at the speed base */                         \
        float    energy_base_j, torque_base_nm;                                                                        \
        T reject;                                         /* of the energy */                                          \
        sd_gain_##N##_t to_energy;                        /* d / base ratio: torque to energy */                       \
        sd_gain_##N##_t gain_energy, gain_mean, gain_reference; /* d l */                                              \
    } sd_fourier_##N##_t;                                                                                              \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. Starts not running. The same tables go to every step. */      \
    sd_result_t sd_fourier_init_##N(sd_fourier_##N##_t *self, const sd_fourier_config_t *config,                       \
                                    const sd_fourier_tables_t *tables);                                                \
    /* The next step begins anew from its own speed, with zero torque. */                                              \
    void sd_fourier_restart_##N(sd_fourier_##N##_t *self);                                                             \
    /* The cycle angle was off by one revolution: odd harmonics change sign, nothing is forgotten. */                  \
    void sd_fourier_shift_revolution_##N(sd_fourier_##N##_t *self);                                                    \
    /* A tooth at cycle_position [0, 2 positions), `advance` (1 to 2 positions) positions and period_ticks after the */\
    /* last one. trusted 0: predict only. A period that no speed in range gives is left out and counted. Returns */    \
    /* the torque at the tooth, Nm, 0 while not running; never NaN. */                                                 \
    float sd_fourier_step_##N(sd_fourier_##N##_t *self, const sd_fourier_tables_t *tables, uint32_t cycle_position,    \
                              uint32_t advance, uint32_t period_ticks, uint8_t trusted);                               \
    /* The same without its result in Nm, which is torque times torque_base_nm. */                                     \
    void sd_fourier_advance_##N(sd_fourier_##N##_t *self, const sd_fourier_tables_t *tables, uint32_t cycle_position,  \
                                uint32_t advance, uint32_t period_ticks, uint8_t trusted);                             \
    /* Estimated torque at any cycle position, Nm. */                                                                  \
    float sd_fourier_torque_at_##N(const sd_fourier_##N##_t *self, const sd_fourier_tables_t *tables,                  \
                                   uint32_t cycle_position);                                                           \
    /* Health and innovation in J, for every tooth; test_ratio 0. */                                                               \
    sd_status_t sd_fourier_status_##N(const sd_fourier_##N##_t *self);                                                 \
    /* The same without innovation and test ratio. */                                                                  \
    sd_status_t sd_fourier_health_##N(const sd_fourier_##N##_t *self);                                                 \
    /* All that is known, for the end of a cycle. */                                                                   \
    void sd_fourier_read_##N(const sd_fourier_##N##_t *self, sd_fourier_estimate_t *estimate);

SD_FOURIER_DECLARE(f32, float)
SD_FOURIER_DECLARE(q31, sd_q31_t)

/// The stability limit of gain_reference for the other gains of *config (docs/theory/torque.md, rule B), 1/rad^2.
float sd_fourier_gain_limit(const sd_fourier_config_t *config);

#ifdef __cplusplus
}
#endif

#endif
