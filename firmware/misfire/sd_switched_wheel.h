/* SPDX-License-Identifier: MIT */
/// sd_switched_wheel.h - document 000's observers on the toothed wheel: acceleration, residual and verdict of every firing.
///
/// Over crank angle a, with v1 = w^2/2 less its mean (w crank speed), the second state is the acceleration itself, dv1/da = dw/dt,
/// and the document's equations (3), (4) read
///     dv1/da = v2,   dv2/da = -k2 v2 - k1 v1 + C Q_n
/// with numbers that are those of the engine and not of its speed (docs/theory/observers.md derives them; the host puts them into the
/// page). A step is a tooth. Q_n is a pulse that begins at the TDC of the active cylinder n, of the work that its commanded
/// fuel should give. Where teeth are missing or doubtful the observer coasts.
///
/// A firing's acceleration a_n is the mean of v2^ from its TDC to the next one, both later by the observer's delay. Its residual
///     D_n = a_n - (f_n - load) - own_n,     f_n: what the commanded work alone would give
/// is what it lacks; load and own_n, an offset of each cylinder, are learned from firings that were found healthy. Nothing is
/// compared with the median of other cylinders, so a pair that fails together is seen. A whole misfire is D_n = -capture f_n,
/// `capture` being the share that the observer shows, whose input was not told of it; the limit is at `definition` of it:
///     index = 1 + D_n / (capture f_n),   misfire where index < definition
///
/// Two variants from one body. q31 takes ticks and q31 work and uses no floating point anywhere. Real-time contract: no heap, no
/// globals, no libm; a tooth costs the positions that it passes. Call order: init; tooth for every placed tooth; judge for a firing
/// that is to be read; restart when the angle was lost or moved.
#ifndef SD_SWITCHED_WHEEL_H
#define SD_SWITCHED_WHEEL_H
#include "sd_limits.h"
#include "sd_misfire_verdict.h"
#include "sd_switched.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_WHEEL_POSITIONS_MAX 120 ///< Of a revolution.
#define SD_WHEEL_INDEX_BITS    4   ///< An index is per unit of 16.

/// Which of document 000's observers.
typedef enum sd_wheel_kind {
    SD_WHEEL_FOLSMO, ///< First order Luenberger sliding mode, equations (5), (6).
    SD_WHEEL_FOSMO,  ///< First order sliding mode.
    SD_WHEEL_ROO,    ///< Reduced order.
    SD_WHEEL_KINDS,  ///< Their number.
} sd_wheel_kind_t;

/// What happens at a position of the cycle: a firing + 1, or 0; flags.
#define SD_WHEEL_OPENS(mark) ((uint32_t)(mark) & 15u)         ///< Its window begins behind this position.
#define SD_WHEEL_READS(mark) (((uint32_t)(mark) >> 4) & 15u)  ///< Its window has ended, and it is read here.
#define SD_WHEEL_FIRES(mark) (((uint32_t)(mark) >> 8) & 15u)  ///< Its pulse begins behind this position.
#define SD_WHEEL_CLOSES 0x1000u ///< The open window ends at this position.
#define SD_WHEEL_BURNED 0x2000u ///< The pulse ends at it.

/// Tables in one number type. Per unit of: energy_base (v1, w^2/2), accel_base (v2), accel_base a radian (input), work_base.
#define SD_WHEEL_TABLES_DECLARE(N)                                                                                     \
    typedef struct sd_wheel_design_##N {                                                                               \
        sd_switched_table_##N##_t table;                                                                               \
        sd_gain_##N##_t sliding; /* rho, a unit of work */                                                             \
        sd_gain_##N##_t capture; /* share of f_n that the window of a misfire lacks, [0, 2] */                  \
    } sd_wheel_design_##N##_t;                                                                                         \
    typedef struct sd_wheel_tables_##N {                                                                               \
        sd_wheel_design_##N##_t design[SD_WHEEL_KINDS];                                                                \
        sd_gain_##N##_t pulse;   /* input while a pulse lasts, a unit of work */                                       \
        sd_gain_##N##_t mean;    /* the mean input over a cycle, which the load takes up */                            \
        sd_gain_##N##_t jump;    /* change of v1 by a firing, a unit of work */                                        \
        sd_gain_##N##_t accel[SD_CYLINDERS_MAX];    /* f_n of a unit of work, by firing order */                       \
        sd_gain_##N##_t per_tooth[SD_CYLINDERS_MAX]; /* 64 over the positions of its window */                         \
    } sd_wheel_tables_##N##_t;

SD_WHEEL_TABLES_DECLARE(f32)
SD_WHEEL_TABLES_DECLARE(q31)

/// Part of the page.
typedef struct sd_wheel_tables {
    uint8_t  positions;       ///< Of a revolution, up to SD_WHEEL_POSITIONS_MAX; 0: no tables, the engine file tells no heat release.
    uint8_t  cylinders;       ///< 1 to SD_CYLINDERS_MAX.
    uint8_t  speed_shift;     ///< Of speed_numerator, [0, 24].
    uint8_t  delay[SD_WHEEL_KINDS]; ///< Positions by which windows come later than TDCs; for the reader, they stand in `mark`.
    uint8_t  reserved[2];     ///< 0.
    int8_t   energy_exponent, accel_exponent, work_exponent, more; ///< Bases are 2^exponent, (rad/s)^2, rad/s^2, J; [0, 30]. more: 0.
    float    speed_per_tick;  ///< The same in f32: speed is speed_per_tick / period.
    uint32_t speed_numerator; ///< Speed, per unit of sqrt(2 energy_base), is speed_numerator 2^speed_shift / period / 2^31.
    uint16_t mark[SD_WHEEL_KINDS][2 * SD_WHEEL_POSITIONS_MAX];
    int32_t  inertia_q31[SD_WHEEL_POSITIONS_MAX]; ///< Inertia half a pitch before each position of a revolution, over the largest.
    sd_wheel_tables_f32_t f32;
    sd_wheel_tables_q31_t q31;
} sd_wheel_tables_t;

/// A placed tooth.
typedef struct sd_wheel_tooth {
    uint16_t cycle_position; ///< [0, 2 positions); another is ignored.
    uint16_t advance;        ///< Positions since the last placed tooth, 1 to 2 positions; another is ignored.
    uint32_t period_ticks;   ///< Since then.
    uint32_t trusted;        ///< 0: the period is in doubt, and is not used.
} sd_wheel_tooth_t;

/// Choices, and an observer with them.
#define SD_WHEEL_DECLARE(N, T)                                                                                         \
    typedef struct sd_wheel_config_##N {                                                                               \
        T definition;           /* Share of the work below which a firing is a misfire, [0.2, 0.8]. */                 \
        T work_min;             /* Commanded work below which nothing is judged, (0, 1). */                            \
        T speed_change;         /* Change of v1 from firing to firing, over v1, that only a shift makes, (0, 1). */    \
        uint16_t start_firings; /* Not judged after a start, while the load is learned. */                             \
        uint16_t hold_firings;  /* Not judged after fuel cut or a shift. */                                            \
        uint8_t  kind;          /* sd_wheel_kind_t. */                                                                 \
    } sd_wheel_config_##N##_t;                                                                                         \
    typedef struct sd_wheel_verdict_##N {                                                                              \
        T accel, residual;      /* a_n, D_n, per unit of accel_base; 0 where there is none. */                         \
        T index;                /* Per unit of 16; 0 when not judged. */                                               \
        uint8_t verdict, inhibit, firing; /* As in sd_misfire_verdict_t; no partial burns. */                          \
    } sd_wheel_verdict_##N##_t;                                                                                        \
    typedef struct sd_wheel_##N {                                                                                      \
        sd_switched_##N##_t observer;                                                                                  \
        T mean;                 /* Of w^2/2. */                                                                        \
        T energy, last_energy;  /* w^2/2 at the last tooth, and at the last firing judged. */                          \
        T now, rest;            /* Input now, and between pulses. */                                                   \
        T sum;                  /* Of v2^ / 64 in the open window. */                                                  \
        T work[SD_CYLINDERS_MAX];  /* Commanded at the last TDC of each firing; negative: unknown. */                  \
        T accel[SD_CYLINDERS_MAX]; /* a_n of its last window. */                                                       \
        T own[SD_CYLINDERS_MAX], load; /* Learned. */                                                                  \
        uint16_t since_start, hold, rejected; /* Firings, saturating; still held; not judged. */                       \
        uint16_t in_row;        /* Misfires without a healthy firing between, up to two cycles. */                     \
        uint8_t  open;          /* The firing whose window is open, + 1; 0: none. */                                   \
        uint8_t  closed;        /* Bit n: accel[n] is of a whole window. */                                            \
        sd_wheel_config_##N##_t config;                                                                                \
    } sd_wheel_##N##_t;                                                                                                \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched: no tables, or a number out of its range. */                   \
    sd_result_t sd_wheel_init_##N(sd_wheel_##N##_t *self, const sd_wheel_config_##N##_t *config, const sd_wheel_tables_t *tables); \
    /* Other choices of the same kind from the next firing on; what was learned stays. As init. */                     \
    sd_result_t sd_wheel_configure_##N(sd_wheel_##N##_t *self, const sd_wheel_config_##N##_t *config);                 \
    /* Begins anew at the next tooth; what was learned of cylinders stays. */                                          \
    void sd_wheel_restart_##N(sd_wheel_##N##_t *self);                                                                 \
    /* Takes a tooth and the work commanded now, [0, 1), per unit; anything else is unknown. Returns the firing, + 1, */ \
    /* that is to be read at it; 0: none. */                                                                           \
    uint32_t sd_wheel_tooth_##N(sd_wheel_##N##_t *self, const sd_wheel_tables_t *tables, const sd_wheel_tooth_t *tooth, T work); \
    /* Judges a firing; inhibit: sd_inhibit_t bits that the caller knows of. A firing out of range is not judged. */   \
    void sd_wheel_judge_##N(sd_wheel_##N##_t *self, const sd_wheel_tables_t *tables, uint32_t firing, uint32_t inhibit, \
                            sd_wheel_verdict_##N##_t *verdict);

SD_WHEEL_DECLARE(f32, float)
SD_WHEEL_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
