/* SPDX-License-Identifier: MIT */
/// sd_airpath_flows.h - the air path as document 001 models it, equation (1): four states, three flows (docs/theory/airpath.md).
///
///     p'   = kappa (-k p + R_air T_charge W_air / V_in + R_exhaust T_egr W_egr / V_in)     intake pressure, kPa
///     ma'  = -k ma + W_air                                                             air in the intake, g
///     me'  = -k me + W_egr                                                             recirculated gas in the intake, g
///     mx'  = k (ma + me) + W_fuel - W_egr - W_t                                        gas in the exhaust manifold, g
///     W_egr = area(opening) p_x / sqrt(R T_x) (1 - ((1 - ratio)/(1 - choked) - 1)^2),  ratio = p/p_x within [choked, 1]
///     W_t   = area(vanes) p_x / sqrt(R T_x) flow sqrt(1 - (p_ambient/p_x)^exponent)
/// Flows in g/s; k: share of the intake's gas that the cylinders take in a second.
///
/// Two variants from one body. q31 is per unit of 2^10 kPa and g (amounts), 2^16 kPa/s and g/s (what flows), 2^6 1/s, 2^11 K, 2^15 rpm;
/// what the model has of its own stands beside it. A number that leaves its base is cut to it.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. Tables are read only.
#ifndef SD_AIRPATH_FLOWS_H
#define SD_AIRPATH_FLOWS_H
#include "sd_bases.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_KNOTS       17 ///< Of what stands over a position or the speed; uniform, straight between.
#define SD_AIRPATH_DROP_KNOTS  33 ///< Of the turbine's law over the pressure ratio 0 to 1.

/// State of the model, in this order.
typedef enum sd_airpath_state {
    SD_AIRPATH_PRESSURE, ///< Of the intake manifold, kPa.
    SD_AIRPATH_AIR,      ///< Fresh air in the intake manifold, g.
    SD_AIRPATH_EGR,      ///< Recirculated gas in the intake manifold, g.
    SD_AIRPATH_EXHAUST,  ///< Gas in the exhaust manifold, g.
    SD_AIRPATH_STATES,   ///< Their number.
} sd_airpath_state_t;

/// Bases of q31, powers of two of the unit.
enum {
    SD_AIRPATH_AMOUNT = 10,    ///< Of a pressure 2^10 kPa, of a mass 2^10 g.
    SD_AIRPATH_FLOW = 16,      ///< 2^16 g/s.
    SD_AIRPATH_EMPTYING = 6,   ///< 2^6 1/s.
    SD_AIRPATH_KELVIN = 11,    ///< 2^11 K.
    SD_AIRPATH_RPM = 15,       ///< 2^15 rpm.
    SD_AIRPATH_PER_GRAM = 10,  ///< 2^10 kPa/g.
    SD_AIRPATH_KAPPA = 1,      ///< 2.
    SD_AIRPATH_GAS = 9,        ///< 2^9 J/(kg K).
    SD_AIRPATH_AREA = 14       ///< 2^14 mm2.
};

/// Model, readings and flows in one number type: N is f32 or q31, T its type; ranges are those of f32.
#define SD_AIRPATH_FLOWS_DECLARE(N, T)                                                                                 \
    typedef struct sd_airpath_model_##N {                                                                              \
        T kappa;               /* [1, 1.5]. */                                                                         \
        T air_kpapgk;          /* kappa R_air / V_in, kPa/(g K), (0, 1]; q31 below 1/2 and per unit of it. */          \
        T egr_kpapgk;          /* kappa R_exhaust / V_in, the same. */                                                 \
        T exhaust_kpapgk;      /* R_exhaust / V_exhaust, the same. */                                                  \
        T exhaust_jpkgk;       /* R of the exhaust gas, J/(kg K), [200, 400]. */                                       \
        T ambient_kpa;         /* Behind the turbine, [50, 120]. */                                                    \
        T rpm_most;            /* Speed of the last knot of `emptying`, [500, 20000]. */                               \
        T emptying_ps[SD_AIRPATH_KNOTS];         /* k over the speed from 0, 1/s, [0, 1000]; q31 below 64. */          \
        T egr_area_mm2[SD_AIRPATH_KNOTS];        /* Effective, over the opening 0 to 1, [0, 1e5]; q31 to 12,800. */    \
        T turbine_area_mm2[SD_AIRPATH_KNOTS];    /* Over the vanes' position 0 to 1, times the law's constant, the same. */ \
        T turbine_drop[SD_AIRPATH_DROP_KNOTS];   /* 1 - ratio^exponent over p_ambient/p_x, [0, 1]. */                  \
    } sd_airpath_model_##N##_t;                                                                                        \
    /* What sensors and commands say at one time; all positive but the two positions, which are cut to [0, 1]. */      \
    typedef struct sd_airpath_in_##N {                                                                                 \
        T speed_rpm, air_gps, fuel_gps;                                                                                \
        T charge_k, egr_k, exhaust_k; /* Behind the two coolers, and in the exhaust manifold. */                       \
        T egr_opening, vgt_position;                                                                                   \
        T intake_kpa, exhaust_kpa;    /* Absolute. */                                                                  \
    } sd_airpath_in_##N##_t;                                                                                           \
    typedef struct sd_airpath_flows_##N {                                                                              \
        T egr_gps, turbine_gps;                                                                                        \
    } sd_airpath_flows_##N##_t;                                                                                        \
    /* What of the model is the same for every estimate at this time. */                                               \
    typedef struct sd_airpath_now_##N {                                                                                \
        T emptying_ps, kappa_k_ps; /* k; kappa k. */                                                                   \
        T air_kpaps;         /* What the air's flow adds to the intake pressure, kPa/s. */                             \
        T per_air, per_egr;  /* kPa/g into the intake pressure, kappa included. */                                     \
        T per_exhaust;       /* kPa/g of the exhaust manifold. */                                                      \
        T egr_gpspkpa;       /* W_egr of 1 kPa at the full fall of pressure. */                                        \
        T turbine_gpspkpa;   /* W_t of 1 kPa without the pressure's law. */                                            \
    } sd_airpath_now_##N##_t;                                                                                          \
    /* Whether every number is within the range said beside it. */                                                     \
    bool sd_airpath_model_ok_##N(const sd_airpath_model_##N##_t *model);                                               \
    void sd_airpath_prepare_##N(const sd_airpath_model_##N##_t *model, const sd_airpath_in_##N##_t *in, sd_airpath_now_##N##_t *now); \
    /* Flows between pressures, kPa; no flow from the intake back. */                                                  \
    void sd_airpath_flow_##N(const sd_airpath_model_##N##_t *model, const sd_airpath_now_##N##_t *now, T intake_kpa, T exhaust_kpa, \
                             sd_airpath_flows_##N##_t *out);                                                           \
    /* x' with these flows, of [kPa, g, g, g] a second. */                                                             \
    void sd_airpath_rate_##N(const sd_airpath_in_##N##_t *in, const sd_airpath_now_##N##_t *now, const T *x,           \
                             const sd_airpath_flows_##N##_t *flows, T *rate);                                          \
    /* A state at rest with the outputs measured: the air that its flow keeps there, the rest of the pressure recirculated gas. */ \
    void sd_airpath_rest_##N(const sd_airpath_in_##N##_t *in, const sd_airpath_now_##N##_t *now, T *x);

SD_AIRPATH_FLOWS_DECLARE(f32, float)
SD_AIRPATH_FLOWS_DECLARE(q31, sd_q31_t)

#ifdef __cplusplus
}
#endif
#endif
