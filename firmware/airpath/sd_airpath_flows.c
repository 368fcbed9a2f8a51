/* SPDX-License-Identifier: MIT */
#include "sd_airpath_flows.h"

#include "sd_math.h"

#define CHOKED         0.65f /* pressure ratio below which the valve's flow no longer grows; Wahlstrom and Eriksson, 2011 */
#define EMPTYING_LEAST 0.1f  /* 1/s: nearly at standstill */

/* Straight between uniform knots over [0, 1]. */
static float between(const float *knots, uint32_t count, float share) {
    const float at = sd_clamp(share, 0.0f, 1.0f) * (float)(count - 1u);
    const uint32_t whole = (uint32_t)at, i = (whole < count - 1u) ? whole : count - 2u;
    return knots[i] + (at - (float)i) * (knots[i + 1u] - knots[i]);
}

void sd_airpath_prepare(const sd_airpath_model_t *model, const sd_airpath_in_t *in, sd_airpath_now_t *now) {
    const float per_root = 1.0f / sd_root(model->exhaust_jpkgk * in->exhaust_k);
    const float emptying = between(model->emptying_ps, SD_AIRPATH_KNOTS, in->speed_rpm / model->rpm_most);
    now->emptying_ps = (emptying > EMPTYING_LEAST) ? emptying : EMPTYING_LEAST;
    now->per_air = model->air_kpapgk * in->charge_k;
    now->per_egr = model->egr_kpapgk * in->egr_k;
    now->per_exhaust = model->exhaust_kpapgk * in->exhaust_k;
    now->egr_gpspkpa = per_root * between(model->egr_area_mm2, SD_AIRPATH_KNOTS, in->egr_opening);
    now->turbine_gpspkpa = per_root * between(model->turbine_area_mm2, SD_AIRPATH_KNOTS, in->vgt_position);
}

void sd_airpath_flow(const sd_airpath_model_t *model, const sd_airpath_now_t *now, float intake_kpa, float exhaust_kpa,
    sd_airpath_flows_t *out) {
    const float exhaust = (exhaust_kpa > model->ambient_kpa) ? exhaust_kpa : model->ambient_kpa;
    const float per_exhaust = 1.0f / exhaust;
    const float ratio = sd_clamp(intake_kpa * per_exhaust, CHOKED, 1.0f);
    const float short_of = (1.0f - ratio) * (1.0f / (1.0f - CHOKED)) - 1.0f;
    const float drop = between(model->turbine_drop, SD_AIRPATH_DROP_KNOTS, model->ambient_kpa * per_exhaust);
    out->egr_gps = now->egr_gpspkpa * exhaust * (1.0f - short_of * short_of);
    out->turbine_gps = now->turbine_gpspkpa * exhaust * sd_root(drop);
}

void sd_airpath_rate(const sd_airpath_model_t *model, const sd_airpath_in_t *in, const sd_airpath_now_t *now, const float *x,
                     const sd_airpath_flows_t *flows, float *rate) {
    const float k = now->emptying_ps;
    rate[SD_AIRPATH_PRESSURE] = now->per_air * in->air_gps + now->per_egr * flows->egr_gps - model->kappa * k * x[SD_AIRPATH_PRESSURE];
    rate[SD_AIRPATH_AIR] = in->air_gps - k * x[SD_AIRPATH_AIR];
    rate[SD_AIRPATH_EGR] = flows->egr_gps - k * x[SD_AIRPATH_EGR];
    rate[SD_AIRPATH_EXHAUST] = k * (x[SD_AIRPATH_AIR] + x[SD_AIRPATH_EGR]) + in->fuel_gps - flows->egr_gps - flows->turbine_gps;
}

void sd_airpath_rest(const sd_airpath_in_t *in, const sd_airpath_now_t *now, float *x) {
    x[SD_AIRPATH_PRESSURE] = in->intake_kpa;
    x[SD_AIRPATH_AIR] = in->air_gps / now->emptying_ps;
    const float left_kpa = in->intake_kpa - now->per_air * x[SD_AIRPATH_AIR];
    x[SD_AIRPATH_EGR] = (left_kpa > 0.0f) ? left_kpa / now->per_egr : 0.0f;
    x[SD_AIRPATH_EXHAUST] = in->exhaust_kpa / now->per_exhaust;
}
