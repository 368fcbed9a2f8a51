/* SPDX-License-Identifier: MIT */
/// sd_afr_point.h - manifold and delay (sd_exhaust.h) at the present operating point, from a grid of the calibration.
///
/// Once a cycle the point is interpolated over speed, intake pressure and mean lambda: sd_afr_point_begin notes where it is, and
/// sd_afr_point_work, called once a tooth while it says that more is left, does it in SD_AFR_PIECES pieces, with the last of which the
/// new point takes effect as a whole. What is measured of the exhaust moves it further: at another temperature T than the grid's the
/// turbine lets sqrt(T) as much through, and gas is as much thinner; other vanes have another area; and a turbine that turns
/// faster than at calibration swallows less (equation (6): d_T depends on the turbocharger's speed). Where a share r of what leaves the
/// manifold is recirculated, 1/(1 - r) of what the turbine lets through flows out, and the pipe to the sensor holds so much more of it.
///
/// Two variants from one body: _f32 and _q31, the latter in integers throughout. Tables are read where the caller keeps them, and must
/// be the same in every call. Real-time contract: no heap, no globals, no libm. One writer per state.
#ifndef SD_AFR_POINT_H
#define SD_AFR_POINT_H
#include "sd_exhaust.h"
#include "sd_uego.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AFR_EGR_MAX   0.7f ///< Largest share of recirculated gas that is believed.
#define SD_AFR_SPEEDS    4 ///< Speeds of the grid.
#define SD_AFR_PRESSURES 3 ///< Intake pressures of the grid.
#define SD_AFR_LAMBDAS   2 ///< Lambdas of the grid.
#define SD_AFR_OPEN      SD_EXHAUST_OPEN ///< Positions of a cycle that a point holds.
#define SD_AFR_PIECE     8 ///< Positions that are interpolated at a time.
#define SD_AFR_PIECES    (SD_AFR_OPEN / SD_AFR_PIECE + 2) ///< Pieces of work until a point is whole.

/// Where the exhaust is in one node of the grid. rate_hz2, per_z0 and per_transport are straight in temperature, so that a point between
/// two nodes of lambda is the exact one.
typedef struct sd_afr_node {
    uint16_t share[SD_AFR_OPEN]; ///< Of the charge, times 65536, from open_position after firing TDC on.
    float    rate_hz2;           ///< The square of rate_hz in sd_exhaust_point_t, 1/s^2.
    float    per_z0;             ///< 1 over z0_kg of sd_exhaust_point_t, 1/kg.
    float    per_transport;      ///< 1/(gas between turbine and sensor), 1/kg; 0: no such gas.
    float    kelvin;             ///< Of the gas in the manifold, mean over a cycle.
} sd_afr_node_t;

/// Part of the calibration page.
typedef struct sd_afr_grid {
    uint8_t  present;            ///< 0: no exhaust side was calibrated.
    uint16_t open_position;      ///< Positions after firing TDC.
    float    speed_radps[SD_AFR_SPEEDS], pressure_bar[SD_AFR_PRESSURES], lambda[SD_AFR_LAMBDAS]; ///< Ascending.
    float    air_kg_per_bar;     ///< Air of one cylinder and cycle, per bar of intake pressure.
    float    behind_bar;         ///< Pressure behind the turbine.
    float    dead_s;             ///< Sensor's dead time.
    float    tau1_s, tau2_s;     ///< Sensor's lags.
    float    mass_base_kg;       ///< Base of masses in q31, as in sd_exhaust_point_t.
    float    psi[SD_EXHAUST_PSI + 1];     ///< Flow function of the turbine over the pressure ratio 0 to 1, over its largest value.
    int32_t  psi_q31[SD_EXHAUST_PSI + 1]; ///< The same, times 2^31.
    sd_uego_gains_t inversion[SD_AFR_SPEEDS]; ///< Of the oscillators, at speed_radps.
    sd_afr_node_t node[SD_AFR_SPEEDS][SD_AFR_PRESSURES][SD_AFR_LAMBDAS];
} sd_afr_grid_t;

/// What is known at the end of a cycle.
typedef struct sd_afr_conditions {
    float speed_radps, intake_bar, fuel_mg; ///< Mean speed; intake pressure; commanded fuel a stroke.
    float exhaust_k;                        ///< Measured in the manifold; 0: not known, as calibrated.
    float vanes;                            ///< Area of the turbine's vanes over the calibration's; 0: not known.
    float turbine_rpm;                      ///< 0: not known.
    float egr_share;                        ///< Recirculated of all that leaves the manifold, (0, SD_AFR_EGR_MAX]; else: none, or not
                                            ///< known.
} sd_afr_conditions_t;

/// Read by init only.
typedef struct sd_afr_point_config {
    uint16_t cycle_positions;           ///< Wheel positions in a cycle, as in sd_exhaust_config_t.
    uint8_t  cylinders;                 ///< 1 to SD_AFR_CYLINDERS_MAX.
    uint16_t firing_position[SD_AFR_CYLINDERS_MAX]; ///< Cycle position of each firing TDC, below cycle_positions, by firing order.
    float    gain_mass;                 ///< Gain L1, as in sd_exhaust_config_t.
    float    turbine_drop, turbine_rpm; ///< Share of its area that a turbine loses when its speed squared grows by turbine_rpm squared, the
                                        ///< speed at which the calibration holds; [0, 1] and [1, 1e6].
} sd_afr_point_config_t;

/// What a piece of work was.
typedef enum sd_afr_progress {
    SD_AFR_DONE, ///< Nothing was left to do, or the exhaust refused the point.
    SD_AFR_MORE, ///< More is left.
    SD_AFR_SET,  ///< The last piece: the point has taken effect.
} sd_afr_progress_t;

/// State and functions of the point in one number type: N is f32 or q31, T its type.
#define SD_AFR_POINT_DECLARE(N, T)                                                                                     \
    typedef struct sd_afr_point_##N {                                                                                  \
        sd_exhaust_##N##_t  exhaust;                                                                                   \
        sd_afr_conditions_t at;                                                                                        \
        float    gain_mass, turbine_drop, turbine_rpm;                                                                 \
        T        part[3];                   /* where the coming point is between two nodes, on each axis, [0, 1], */   \
        uint8_t  node[3];                   /* and the first of them */                                                \
        uint8_t  piece;                     /* the next piece; SD_AFR_PIECES: none */                                  \
        sd_real_##N##_t mean_lambda;        /* that it is for */                                                       \
        sd_real_##N##_t rate_hz, z0_kg, transport_kg;                                                                  \
        float    step_s;                    /* duration of a position at the point that is set; 0: none is */          \
    } sd_afr_point_##N##_t;                                                                                            \
    /* SD_OK if init takes it, else SD_ERR_CONFIG. */                                                                  \
    sd_result_t sd_afr_point_check_##N(const sd_afr_point_config_t *config, const sd_afr_grid_t *grid);                \
    /* SD_OK, or SD_ERR_CONFIG with the state untouched. Nothing flows until the first point is set. */                \
    sd_result_t sd_afr_point_init_##N(sd_afr_point_##N##_t *self, const sd_afr_point_config_t *config, const sd_afr_grid_t *grid); \
    /* Ends a cycle: the operating point of the coming one. Out of the grid its edge stands; speed and intake pressure that */ \
    /* are not above 0 (NaN too) keep the last point: false. What was left to do for an earlier point is left out. */  \
    bool sd_afr_point_begin_##N(sd_afr_point_##N##_t *self, const sd_afr_conditions_t *at, sd_real_##N##_t mean_lambda); \
    /* mean_lambda is what burned in the cylinders: of recirculated gas it has none. */                               \
    /* The next piece of that; late_s is added to the sensor's dead time. */                                           \
    sd_afr_progress_t sd_afr_point_work_##N(sd_afr_point_##N##_t *self, const sd_afr_grid_t *grid, float late_s);       \
    /* The oscillators' gains at the point. */                                                                         \
    void sd_afr_point_gains_##N(const sd_afr_point_##N##_t *self, const sd_afr_grid_t *grid, sd_uego_gains_t *gains);

SD_AFR_POINT_DECLARE(f32, float)
SD_AFR_POINT_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif

#endif
