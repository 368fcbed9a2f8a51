/* SPDX-License-Identifier: MIT */
/// sd_exhaust.h - gas in the exhaust manifold over crank angle, and the delay to the sensor: blocks B and C of
/// document 004, Figure 13.
///
/// B, open loop, equation (6), one explicit Euler step a wheel position:
///     M += sum over i of D_i - rate dt psi(M / z0) M,   D_i = charge share(alpha - TDC_i)
///     psi(z) = sqrt(2 g/(g-1) (z^(-2/g) - z^(-(g+1)/g))) for 1 < z, constant above the choke, 0 up to 1
/// where share is the part of a cylinder's gas that passes its valve within one position. It needs no pressure sensor;
/// where there is one, sd_exhaust_measured brings M towards what it says, by L1 of equation (9). The document lets the outflow be
/// as modelled. Then a wrong turbine area leaves more air flowing in than out for ever, which the observer would take for leaner
/// cylinders; so here the same error also moves a factor on the outflow, until what flows in flows out.
/// C: a ring of what B said keeps M and its outflow; read with the transport delay it gives the gas that the sensor meets
/// now. Flows need no ring: a delay moves the place in the table. The delay is a mass that must have left after a gas
/// before it is through the pipe, so that it breathes with the outflow, and a time on top of it; a mass of 0 gives the
/// document's constant delay. Where the delay grows within a position, the sensor sees that much less than a position.
///
/// Two variants from one body: _f32 and _q31 (masses per unit of mass_base). Real-time contract: no heap, no globals,
/// no libm; step costs one pass over the cylinders and does not divide whole numbers. Call order: init; for each operating
/// point shares, a piece at a time, then set, with which all of it takes effect (once a cycle, it divides); step for every
/// wheel position, missing ones included. psi stays where the caller keeps it. One writer per state.
#ifndef SD_EXHAUST_H
#define SD_EXHAUST_H
#include "sd_limits.h"
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AFR_CYLINDERS_MAX SD_CYLINDERS_MAX ///< Cylinders of an engine.
#define SD_AFR_POSITIONS_MAX 240 /* of a cycle */
#define SD_EXHAUST_RING      64  /* positions, a power of two: the longest delay is one less */
#define SD_EXHAUST_PSI       32  /* intervals of psi over z from 1 to 2 */
#define SD_EXHAUST_OPEN      96  /* positions of a cycle in which a valve may be open */

/// Read by init only, need not outlive it.
typedef struct sd_exhaust_config {
    uint16_t cycle_positions;    ///< Wheel positions a cycle, 24 to SD_AFR_POSITIONS_MAX.
    uint8_t  cylinders;          ///< 1 to SD_AFR_CYLINDERS_MAX.
    uint16_t firing_position[SD_AFR_CYLINDERS_MAX]; ///< First position at or after each firing TDC, below cycle_positions.
    uint16_t open_position;      ///< Positions from there to the first in which the valve may be open, below cycle_positions.
    float    mass_base_kg;       ///< Base of q31: above all the gas the manifold ever holds, (0, 1].
    float    gain_mass;          ///< L1, of the manifold's gas, a position with a pressure, [0, 1]; 0: pressure is not used.
} sd_exhaust_config_t;

/// Operating point; read by set only.
typedef struct sd_exhaust_point {
    float charge_kg;       ///< Gas of one cylinder in one cycle, fuel included, (0, mass_base).
    float rate_hz;         ///< Turbine area sqrt(R T)/manifold volume, [0, 1000].
    float z0_kg;           ///< Mass in the manifold at the pressure behind the turbine, (0, mass_base).
    float pipe_kg;         ///< Gas between turbine and sensor, [0, mass_base).
    float delay_positions; ///< Beside that; below 0 it shortens the pipe's, at most to none. A whole delay beyond the ring is
                           ///< cut and said so.
    float behind_bar;      ///< Pressure behind the turbine, [0.1, 10]; 0: pressure is not used.
} sd_exhaust_point_t;

#define SD_EXHAUST_BAR 16 /* what a measured pressure is per unit of */

/// State and functions of the manifold in one number type: N is f32 or q31, T its type.
#define SD_EXHAUST_DECLARE(N, T)                                                                                       \
    /* The gas that the sensor meets at this position; masses per unit of mass_base. */                                \
    typedef struct sd_exhaust_now_##N {                                                                                \
        T mass, out;                        /* in the manifold; leaving it within the position */                      \
        T charge;                           /* gas of one cylinder in one cycle */                                     \
        T share[SD_AFR_CYLINDERS_MAX];      /* of each charge within the position, by firing order; */                  \
        uint8_t count, flowing[SD_AFR_CYLINDERS_MAX]; /* how many are above 0, and which, ascending */                 \
    } sd_exhaust_now_##N##_t;                                                                                          \
    typedef struct sd_exhaust_##N {                                                                                    \
        T mass;                             /* M */                                                                    \
        T before;                           /* manifold before the last position */                                     \
        T outflow;                          /* half the factor on the outflow that pressure asks for, [1/4, 1) */       \
        T inside, pipe;                     /* outflow that is in the pipe, and how much the pipe holds */             \
        T delay;                            /* whole delay, over the ring */                                           \
        T charge;                                                                                                      \
        T late;                             /* fraction of a position in the constant part of the delay, */            \
        T waited;                           /* all of that part over the ring, */                                      \
        uint32_t wait;                      /* and its whole positions; */                                             \
        T early;                            /* what is below 0 of it, over the ring */                                 \
        sd_gain_##N##_t to_z, rate;         /* M to z/2; M psi to outflow a position, times 2 for `outflow` */         \
        sd_gain_##N##_t of_pressure;        /* pressure to M */                                                        \
        sd_gain_##N##_t gain_mass, gain_outflow; /* L1; of `outflow`, for an error of M */                             \
        sd_gain_##N##_t to_positions;       /* from parts of the ring */                                               \
        float    mass_base_kg;                                                                                         \
        uint32_t at;                        /* last written */                                                         \
        uint32_t held;                      /* positions whose outflow is in the pipe */                               \
        uint16_t cycle_positions;                                                                                      \
        uint16_t open_at[SD_AFR_CYLINDERS_MAX]; /* first cycle position of each cylinder's shares */                   \
        uint16_t open[2];                   /* how many positions from there on something passes, of either shares */  \
        uint8_t  cylinders, set, cut;       /* cut: the delay is longer than the ring */                               \
        uint8_t  present, changed;          /* which shares are the present ones; 1: the others count from the next set on */\
        T ring_mass[SD_EXHAUST_RING], ring_out[SD_EXHAUST_RING];                                                       \
        T ring_piped[SD_EXHAUST_RING];      /* how long ago what leaves the pipe left the manifold, over the ring */   \
        /* Of the present point and of the coming one: share k at k + 1, with what stands before and behind them. */    \
        T share[2][SD_EXHAUST_OPEN + 2];                                                                               \
    } sd_exhaust_##N##_t;                                                                                              \
    /* SD_OK if init takes it, else SD_ERR_CONFIG. */                                                                  \
    sd_result_t sd_exhaust_check_##N(const sd_exhaust_config_t *config);                                               \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. Nothing flows until the first set. */                         \
    sd_result_t sd_exhaust_init_##N(sd_exhaust_##N##_t *self, const sd_exhaust_config_t *config);                      \
    /* Some of the coming point's shares, `first` to `first + count - 1` counted from open_position on: which part of a */ \
    /* cylinder's gas passes its valve in each position, [0, 1). The rest of the gas stays in the cylinder. SD_OK, or */ \
    /* SD_ERR_CONFIG with none of them taken: one out of its range (NaN too), or beyond SD_EXHAUST_OPEN. */            \
    sd_result_t sd_exhaust_shares_##N(sd_exhaust_##N##_t *self, uint32_t first, uint32_t count, const T *share);   \
    /* SD_OK, or SD_ERR_CONFIG with the last point kept: a field out of its range (NaN included). step_s is the */     \
    /* duration of a position, (0, 0.1]. The first point fills the manifold to z0. Without new shares the last stay. */ \
    sd_result_t sd_exhaust_set_##N(sd_exhaust_##N##_t *self, const sd_exhaust_point_t *point, float step_s);           \
    /* Next position, below cycle_positions. psi: [SD_EXHAUST_PSI + 1], psi(1 + k/32), each [0, 1). *now is all zero */ \
    /* before the first set. */                                                                                        \
    void sd_exhaust_step_##N(sd_exhaust_##N##_t *self, const T *psi, uint32_t cycle_position, sd_exhaust_now_##N##_t *now); \
    /* The pressure measured within the position stepped last, bar over SD_EXHAUST_BAR, (0, 1): the gas in the manifold */ \
    /* and the factor on the outflow move. What is outside (NaN too), or comes before a point, is ignored. */          \
    void sd_exhaust_measured_##N(sd_exhaust_##N##_t *self, T pressure);

SD_EXHAUST_DECLARE(f32, float)
SD_EXHAUST_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
