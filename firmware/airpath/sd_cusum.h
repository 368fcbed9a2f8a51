/* SPDX-License-Identifier: MIT */
/// sd_cusum.h - multi-CUSUM: which of some hypotheses about the mean of a vector of residuals has come true, and since when. It knows
/// nothing of where residuals come from. After I. Nikiforov, 1998, and M. Kinnaert and others, 2000, as document 001 uses them.
///
///     s_l = (mu_l)' S^-1 (r - mu_l/2),   g_l = max(0, g_l + s_l)              mean of r: 0 without a fault, mu_l with fault l
///     n_l: steps since g_l last left 0;   fault l is named while  g_l > detect  and  g_l - g_j > isolate for every other j
/// The largest sum grows to 2 (detect + isolate) and takes the others down with it, to 1.5 detect at least. So a fault is no longer named
/// soon after it ended, however long it lasted.
/// S is the covariance that a sum of residuals has for each of its terms (long-run covariance): that of one residual only where residuals
/// are white. With isolate = detect this is the document's simplified form (31). Hypotheses belong to groups, e.g. the two signs of one
/// actuator's fault: hypotheses of different groups above `detect` at once mean that no single fault explains the residuals.
///
/// Two variants from one body. In q31 sums, thresholds and what a step takes off are per unit of 2^16, residuals per unit of 2^10 of their
/// unit, and weights coefficients of sd_bases.h between the two.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. One writer per state, plain data without pointers; tables are
/// read only.
#ifndef SD_CUSUM_H
#define SD_CUSUM_H
#include "sd_bases.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_CUSUM_HYPOTHESES_MAX 8 ///< Faults that are weighed against health.
#define SD_CUSUM_RESIDUALS_MAX  4 ///< Residuals that they are weighed by.
#define SD_CUSUM_BITS           16 ///< Of sums.
#define SD_CUSUM_WEIGHT_BITS    11 ///< Of weights over 1/residual: 5 of a coefficient, and 2^16 over 2^10.

/// Tables, state and functions in one number type: N is f32 or q31, T its type.
#define SD_CUSUM_DECLARE(N, T)                                                                                         \
    typedef struct sd_cusum_tables_##N {                                                                               \
        T       weight[SD_CUSUM_HYPOTHESES_MAX][SD_CUSUM_RESIDUALS_MAX]; /* S^-1 mu_l, within +-1e6. */                \
        T       offset[SD_CUSUM_HYPOTHESES_MAX]; /* mu_l' S^-1 mu_l / 2, what a step takes off, (0, 1e6]. */           \
        uint8_t group[SD_CUSUM_HYPOTHESES_MAX];  /* Of each hypothesis, from 0, below 8. */                            \
        uint8_t hypotheses;                      /* 1 to SD_CUSUM_HYPOTHESES_MAX. */                                   \
        uint8_t residuals;                       /* 1 to SD_CUSUM_RESIDUALS_MAX. */                                    \
        uint8_t reserved[2];                     /* 0. */                                                              \
    } sd_cusum_tables_##N##_t;                                                                                         \
    typedef struct sd_cusum_thresholds_##N {                                                                           \
        T detect, isolate; /* (0, 1e4] each. */                                                                        \
    } sd_cusum_thresholds_##N##_t;                                                                                     \
    typedef struct sd_cusum_##N {                                                                                      \
        T        g[SD_CUSUM_HYPOTHESES_MAX]; /* [0, 2 (detect + isolate)]. */                                          \
        uint32_t n[SD_CUSUM_HYPOTHESES_MAX]; /* Steps since g last left 0, this one included, saturating; 0 while it is 0. */ \
    } sd_cusum_##N##_t;                                                                                                \
    typedef struct sd_cusum_out_##N {                                                                                  \
        T decision[SD_CUSUM_HYPOTHESES_MAX]; /* min over the others of what is above its threshold: positive where l is named. */ \
        uint32_t since_steps; /* Of the hypothesis named: steps since the fault's most likely time. */                 \
        uint8_t  named;       /* Hypothesis from 1, or 0: none. */                                                     \
        uint8_t  groups;      /* Bit i: a hypothesis of group i is above `detect`. */                                  \
    } sd_cusum_out_##N##_t;                                                                                            \
    /* Whether every number is within the range said beside it. */                                                     \
    bool sd_cusum_tables_ok_##N(const sd_cusum_tables_##N##_t *tables);                                                \
    bool sd_cusum_thresholds_ok_##N(const sd_cusum_thresholds_##N##_t *thresholds);                                    \
    /* All sums 0. */                                                                                                  \
    void sd_cusum_start_##N(sd_cusum_##N##_t *self);                                                                   \
    /* Takes a vector of residuals, each within +-1e6, and decides. */                                                 \
    void sd_cusum_step_##N(sd_cusum_##N##_t *self, const sd_cusum_tables_##N##_t *tables,                              \
                           const sd_cusum_thresholds_##N##_t *thresholds, const T *residual, sd_cusum_out_##N##_t *out); \
    /* Decides again from what was taken, for a step without residuals. */                                             \
    void sd_cusum_read_##N(const sd_cusum_##N##_t *self, const sd_cusum_tables_##N##_t *tables,                        \
                           const sd_cusum_thresholds_##N##_t *thresholds, sd_cusum_out_##N##_t *out);

SD_CUSUM_DECLARE(f32, float)
SD_CUSUM_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif
#endif
