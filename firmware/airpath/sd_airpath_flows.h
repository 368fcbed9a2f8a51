/* SPDX-License-Identifier: MIT */
/// sd_airpath_flows.h - the air path as document 001 models it: four states, three flows (docs/airpath.md).
///
///     p'   = kappa (-k p + R_air T_charge W_air / V_in + R_exhaust T_egr W_egr / V_in)     intake pressure, kPa
///     ma'  = -k ma + W_air                                                             air in the intake, g
///     me'  = -k me + W_egr                                                             recirculated gas in the intake, g
///     mx'  = k (ma + me) + W_fuel - W_egr - W_t                                        gas in the exhaust manifold, g
///     W_egr = area(opening) p_x / sqrt(R T_x) (1 - ((1 - ratio)/(1 - choked) - 1)^2),  ratio = p/p_x within [choked, 1]
///     W_t   = area(vanes) p_x / sqrt(R T_x) flow sqrt(1 - (p_ambient/p_x)^exponent)
/// Flows in g/s; k: share of the intake's gas that the cylinders take in a second.
///
/// Real-time contract: no heap, no globals, no I/O, no libm; constant time. Tables are read only.
#ifndef SD_AIRPATH_FLOWS_H
#define SD_AIRPATH_FLOWS_H
#include "sd_num.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_AIRPATH_KNOTS       17 ///< Of what stands over a position or the speed; uniform, straight between.
#define SD_AIRPATH_DROP_KNOTS  33 ///< Of the turbine's law over the pressure ratio 0 to 1.

/// State of the model, in this order.
typedef enum sd_airpath_state { SD_AIRPATH_PRESSURE, SD_AIRPATH_AIR, SD_AIRPATH_EGR, SD_AIRPATH_EXHAUST,
    SD_AIRPATH_STATES } sd_airpath_state_t;

typedef struct sd_airpath_model {
    float kappa;               ///< [1, 1.5].
    float air_kpapgk;          ///< kappa R_air / V_in, kPa/(g K), (0, 1].
    float egr_kpapgk;          ///< kappa R_exhaust / V_in, kPa/(g K), (0, 1].
    float exhaust_kpapgk;      ///< R_exhaust / V_exhaust, kPa/(g K), (0, 1].
    float exhaust_jpkgk;       ///< R of the exhaust gas, J/(kg K), [200, 400].
    float ambient_kpa;         ///< Behind the turbine, [50, 120].
    float rpm_most;            ///< Speed of the last knot of `emptying`, [500, 20000].
    float emptying_ps[SD_AIRPATH_KNOTS];         ///< k over the speed from 0, 1/s, [0, 1000].
    float egr_area_mm2[SD_AIRPATH_KNOTS];        ///< Effective, over the opening 0 to 1, [0, 1e5].
    float turbine_area_mm2[SD_AIRPATH_KNOTS];    ///< Effective, over the vanes' position 0 to 1, times the law's constant, [0, 1e5].
    float turbine_drop[SD_AIRPATH_DROP_KNOTS];   ///< 1 - ratio^exponent over p_ambient/p_x, [0, 1].
} sd_airpath_model_t;

/// What sensors and commands say at one time; all positive but the two positions, which are cut to [0, 1].
typedef struct sd_airpath_in {
    float speed_rpm, air_gps, fuel_gps;
    float charge_k, egr_k, exhaust_k; ///< Behind the two coolers, and in the exhaust manifold.
    float egr_opening, vgt_position;
    float intake_kpa, exhaust_kpa;    ///< Absolute.
} sd_airpath_in_t;

typedef struct sd_airpath_flows {
    float egr_gps, turbine_gps;
} sd_airpath_flows_t;

/// What of the model is the same for every estimate at this time.
typedef struct sd_airpath_now {
    float emptying_ps;       ///< k.
    float per_air, per_egr;  ///< kPa/g into the intake pressure, kappa included.
    float per_exhaust;       ///< kPa/g of the exhaust manifold.
    float egr_gpspkpa;       ///< W_egr of 1 kPa at the full fall of pressure.
    float turbine_gpspkpa;   ///< W_t of 1 kPa without the pressure's law.
} sd_airpath_now_t;

void sd_airpath_prepare(const sd_airpath_model_t *model, const sd_airpath_in_t *in, sd_airpath_now_t *now);
/// Flows between pressures, kPa; no flow from the intake back.
void sd_airpath_flow(const sd_airpath_model_t *model, const sd_airpath_now_t *now, float intake_kpa, float exhaust_kpa,
    sd_airpath_flows_t *out);
/// x' with these flows, of [kPa, g, g, g] a second.
void sd_airpath_rate(const sd_airpath_model_t *model, const sd_airpath_in_t *in, const sd_airpath_now_t *now, const float *x,
                     const sd_airpath_flows_t *flows, float *rate);
/// A state at rest with the outputs measured: the air that its flow keeps there, the rest of the pressure recirculated gas.
void sd_airpath_rest(const sd_airpath_in_t *in, const sd_airpath_now_t *now, float *x);

#ifdef __cplusplus
}
#endif
#endif
