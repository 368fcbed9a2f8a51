/* SPDX-License-Identifier: MIT */
/// sd_airpath_bank.h - which actuator of the air path is faulty: two unknown-input observers, one blind to each actuator's fault, the
/// offsets of their residuals, and the multi-CUSUM that decides (document 001, Figure 8, Algorithm 3, equation (31);
/// docs/theory/airpath.md).
///
///     state 0 waits  -> 1 settles -> 2 learns -> 3 decides        a sensor that is silent or stuck, or a restart: back to 0
/// While the engine moves from one operating point to another nothing is decided; at another point than that where offsets were learned
/// they are learned anew (back to 2), unless a fault was named.
/// Residual 1 sees the turbine's vanes (VGT) and residual 2 the recirculation valve (EGR); both are kPa.
///
/// Two variants from one body; q31 with the bases of its parts, and the whole for cores without a floating-point unit.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers; tables are
/// read only, in flash. Call order: start; then every period either step, or hold while a measurement is missing, or start again.
#ifndef SD_AIRPATH_BANK_H
#define SD_AIRPATH_BANK_H
#include "sd_airpath_flows.h"
#include "sd_airpath_offsets.h"
#include "sd_airpath_point.h"
#include "sd_cusum.h"
#include "sd_nuio.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_OBSERVERS 2 ///< One for each actuator.
#define SD_AIRPATH_FAULTS    5 ///< Base in q31 of what is in faults of interest: 2^5.

/// Groups of the hypotheses, and bits of what is said to be faulty.
typedef enum sd_airpath_fault {
    SD_AIRPATH_NO_FAULT  = 0, ///< Nothing is said to be faulty.
    SD_AIRPATH_EGR_FAULT = 1, ///< The EGR valve.
    SD_AIRPATH_VGT_FAULT = 2, ///< The turbine's vanes.
    SD_AIRPATH_UNCLEAR   = 3, ///< One of both, or neither: the residuals do not tell them apart.
} sd_airpath_fault_t;
/// How far the block has come.
typedef enum sd_airpath_phase {
    SD_AIRPATH_WAITS,   ///< For readings within their ranges.
    SD_AIRPATH_SETTLES, ///< The observers' start dies out.
    SD_AIRPATH_LEARNS,  ///< The offsets of healthy residuals.
    SD_AIRPATH_DECIDES, ///< Faults are looked for.
} sd_airpath_phase_t;

/// State and functions of the bank in one number type: N is f32 or q31, T its type.
#define SD_AIRPATH_BANK_DECLARE(N, T)                                                                                  \
    /* Of the calibration page. */                                                                                     \
    typedef struct sd_airpath_tables_##N {                                                                             \
        uint32_t present;                /* 1: there is an air path with a design; 0: all the rest is 0. */            \
        T        period_s;               /* Of a step, (0, 0.1]; q31 below 1/64. */                                    \
        T        emptying_low_ps, emptying_high_ps; /* Ends of the schedule, (0, 1000], ascending. */                  \
        T        fault[SD_AIRPATH_RESIDUALS];       /* Residual that a fault of interest leaves in the end, kPa, (0, 1e4]: half */ \
                                                    /* of it is suspect. */                                            \
        sd_airpath_model_##N##_t model;                                                                                \
        sd_nuio_table_##N##_t    observer[SD_AIRPATH_OBSERVERS];                                                       \
        sd_cusum_tables_##N##_t  cusum;  /* Hypotheses in pairs of either sign: group 0 EGR, 1 VGT, more: what is neither. */ \
    } sd_airpath_tables_##N##_t;                                                                                       \
    typedef struct sd_airpath_bank_##N {                                                                               \
        sd_airpath_offsets_##N##_t offsets;                                                                            \
        sd_nuio_##N##_t          observer[SD_AIRPATH_OBSERVERS];                                                       \
        sd_airpath_point_##N##_t point;                                                                                \
        sd_cusum_##N##_t         cusum;                                                                                \
        uint32_t steps;                      /* In the present phase, saturating. */                                   \
        T        residual[SD_AIRPATH_RESIDUALS]; /* Of the last step, without the offset. */                           \
        uint16_t rejected;                   /* Steps held, saturating. */                                             \
        uint8_t  phase;                      /* sd_airpath_phase_t. */                                                 \
        uint8_t  said;                       /* 1: a fault was named with the offsets of now, which are therefore kept. */ \
    } sd_airpath_bank_##N##_t;                                                                                         \
    typedef struct sd_airpath_config_##N {                                                                             \
        uint32_t settle_steps; /* After a start, [0, 1e5]. */                                                          \
        uint32_t window_steps; /* In which offsets are learned, [0, 1e5]; 0: none are. */                              \
        sd_cusum_thresholds_##N##_t thresholds;                                                                        \
    } sd_airpath_config_##N##_t;                                                                                       \
    typedef struct sd_airpath_out_##N {                                                                                \
        T residual_kpa[SD_AIRPATH_RESIDUALS];      /* Without the learned offset. */                                   \
        T offset_faults[SD_AIRPATH_RESIDUALS];     /* What was learned, over what a fault of interest leaves. */       \
        sd_cusum_out_##N##_t decision;  /* named 0 unless it decides; its time counts from the fault's most likely beginning. */ \
        uint8_t fault;                  /* sd_airpath_fault_t: the actuator named, or SD_AIRPATH_UNCLEAR: both, or something else. */ \
        uint8_t phase;                  /* sd_airpath_phase_t. */                                                      \
        sd_status_t status;             /* Invalid until it decides; degraded while it holds, and while what was learned is suspect. */ \
    } sd_airpath_out_##N##_t;                                                                                          \
    /* Whether every number is within the range said beside it. */                                                     \
    bool sd_airpath_tables_ok_##N(const sd_airpath_tables_##N##_t *tables);                                            \
    /* Waits, and forgets what it learned. */                                                                          \
    void sd_airpath_start_##N(sd_airpath_bank_##N##_t *self);                                                          \
    /* Waits, and keeps what it learned: a measurement is lost. */                                                     \
    void sd_airpath_wait_##N(sd_airpath_bank_##N##_t *self, sd_airpath_out_##N##_t *out);                              \
    /* A period without one of its measurements: sums and window stay, nothing is named anew. */                       \
    void sd_airpath_hold_##N(sd_airpath_bank_##N##_t *self, const sd_airpath_tables_##N##_t *tables,                   \
                             const sd_airpath_config_##N##_t *config, sd_airpath_out_##N##_t *out);                    \
    /* A period with all measurements. An estimate that leaves the range of its numbers is begun anew. */              \
    void sd_airpath_step_##N(sd_airpath_bank_##N##_t *self, const sd_airpath_tables_##N##_t *tables,                   \
                             const sd_airpath_config_##N##_t *config, const sd_airpath_in_##N##_t *in, sd_airpath_out_##N##_t *out);

SD_AIRPATH_BANK_DECLARE(f32, float)
SD_AIRPATH_BANK_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif
#endif
