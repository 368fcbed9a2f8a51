/* SPDX-License-Identifier: MIT */
/* The air path's diagnosis at one point of a six-cylinder diesel, with numbers as a design makes them. */
#include "board.h"
#include "budget_blocks.h"
#include "sd_airpath_bank.h"

static volatile float kept;

static void fill_model(sd_airpath_model_f32_t *m) {
    m->kappa = 1.0f, m->air_kpapgk = 0.01594f, m->egr_kpapgk = 0.01589f, m->exhaust_kpapgk = 0.04767f, m->exhaust_jpkgk = 286.0f;
    m->ambient_kpa = 101.11f, m->rpm_most = 4000.0f;
    for (uint32_t i = 0; i < SD_AIRPATH_KNOTS; i++) {
        const float share = (float)i / (float)(SD_AIRPATH_KNOTS - 1);
        m->emptying_ps[i] = 12.07f * share, m->egr_area_mm2[i] = 300.0f * share, m->turbine_area_mm2[i] = 114.0f + 533.0f * share;
    }
    for (uint32_t i = 0; i < SD_AIRPATH_DROP_KNOTS; i++) {
        const float ratio = (float)i / (float)(SD_AIRPATH_DROP_KNOTS - 1);
        m->turbine_drop[i] = 1.0f - ratio * ratio * ratio;
    }
}

static void fill_tables(sd_airpath_tables_f32_t *t) {
    t->present = 1u, t->period_s = 0.01f, t->emptying_low_ps = 3.0f, t->emptying_high_ps = 6.0f, t->fault[0] = 4.6f, t->fault[1] = 1.7f;
    fill_model(&t->model);
    for (uint32_t o = 0; o < SD_AIRPATH_OBSERVERS; o++) {
        sd_nuio_table_f32_t *n = &t->observer[o];
        for (uint32_t i = 0; i < SD_NUIO_STATES; i++) { n->m[i][i] = 1.0f; }
        n->m[3][3] = 0.0f, n->e[3][1] = -1.0f, n->k[0][0] = 3.0f, n->k[3][1] = 5.0f, n->more[0][0] = -1.0f, n->gamma[0] = 1.0f;
    }
    t->cusum.hypotheses = 4u, t->cusum.residuals = 2u;
    for (uint32_t l = 0; l < 4u; l++) {
        t->cusum.weight[l][(l < 2u) ? 1 : 0] = (l % 2u == 0u) ? 1.0f : -1.0f;
        t->cusum.offset[l] = 0.5f, t->cusum.group[l] = (uint8_t)(l / 2u);
    }
}

static void per(const float *from, sd_q31_t *to, uint32_t count, int bits) {
    for (uint32_t i = 0; i < count; i++) { to[i] = sd_given_q31(from[i], bits); }
}

/* The same numbers per unit of their bases. */
static void fill_fixed(const sd_airpath_tables_f32_t *f, sd_airpath_tables_q31_t *t) {
    const int moved = SD_WIDE_BITS, gain = SD_WIDE_BITS + SD_AIRPATH_EMPTYING, per_kelvin = SD_AIRPATH_PER_GRAM - SD_AIRPATH_KELVIN;
    t->present = 1u;
    per(&f->period_s, &t->period_s, 1u, -SD_AIRPATH_PERIOD);
    per(&f->emptying_low_ps, &t->emptying_low_ps, 2u, SD_AIRPATH_EMPTYING);
    per(f->fault, t->fault, SD_AIRPATH_RESIDUALS, SD_AIRPATH_AMOUNT);
    per(&f->model.kappa, &t->model.kappa, 1u, SD_AIRPATH_KAPPA);
    per(&f->model.air_kpapgk, &t->model.air_kpapgk, 3u, per_kelvin);
    per(&f->model.exhaust_jpkgk, &t->model.exhaust_jpkgk, 1u, SD_AIRPATH_GAS);
    per(&f->model.ambient_kpa, &t->model.ambient_kpa, 1u, SD_AIRPATH_AMOUNT);
    per(&f->model.rpm_most, &t->model.rpm_most, 1u, SD_AIRPATH_RPM);
    per(f->model.emptying_ps, t->model.emptying_ps, SD_AIRPATH_KNOTS, SD_AIRPATH_EMPTYING);
    per(f->model.egr_area_mm2, t->model.egr_area_mm2, 2u * SD_AIRPATH_KNOTS, SD_AIRPATH_AREA);
    per(f->model.turbine_drop, t->model.turbine_drop, SD_AIRPATH_DROP_KNOTS, 0);
    for (uint32_t o = 0; o < SD_AIRPATH_OBSERVERS; o++) {
        per(&f->observer[o].m[0][0], &t->observer[o].m[0][0], 24u, moved); /* m and e */
        per(&f->observer[o].k[0][0], &t->observer[o].k[0][0], 16u, gain); /* k and more */
        per(f->observer[o].gamma, t->observer[o].gamma, SD_NUIO_OUTPUTS, moved);
    }
    per(&f->cusum.weight[0][0], &t->cusum.weight[0][0], SD_CUSUM_HYPOTHESES_MAX * SD_CUSUM_RESIDUALS_MAX, SD_CUSUM_WEIGHT_BITS);
    per(f->cusum.offset, t->cusum.offset, SD_CUSUM_HYPOTHESES_MAX, SD_CUSUM_BITS);
    for (uint32_t l = 0; l < f->cusum.hypotheses; l++) { t->cusum.group[l] = f->cusum.group[l]; }
    t->cusum.hypotheses = f->cusum.hypotheses, t->cusum.residuals = f->cusum.residuals;
}

static sd_airpath_in_q31_t fixed_of(const sd_airpath_in_f32_t *in) {
    sd_airpath_in_q31_t q;
    per(&in->speed_rpm, &q.speed_rpm, 1u, SD_AIRPATH_RPM);
    per(&in->air_gps, &q.air_gps, 2u, SD_AIRPATH_FLOW);
    per(&in->charge_k, &q.charge_k, 3u, SD_AIRPATH_KELVIN);
    per(&in->egr_opening, &q.egr_opening, 2u, 0);
    per(&in->intake_kpa, &q.intake_kpa, 2u, SD_AIRPATH_AMOUNT);
    return q;
}

static sd_airpath_in_f32_t sensed(uint32_t k) {
    const float noise = (float)((k * 7u) & 15u) / 16.0f - 0.5f;
    return (sd_airpath_in_f32_t){ .speed_rpm = 1500.0f + noise, .air_gps = 113.0f, .fuel_gps = 7.0f, .charge_k = 310.0f, .egr_k = 370.0f,
                                  .exhaust_k = 720.0f, .egr_opening = 0.35f, .vgt_position = 0.44f, .intake_kpa = 153.4f + noise,
                                  .exhaust_kpa = 174.0f - 2.0f * noise };
}

uint32_t budget_count_airpath(uint32_t not_counted, uint32_t step) {
    static sd_airpath_tables_f32_t tables;
    static sd_airpath_tables_q31_t fixed;
    static sd_airpath_bank_f32_t bank;
    static sd_airpath_bank_q31_t fixed_bank;
    const sd_airpath_config_f32_t config = { .settle_steps = 20u, .window_steps = 50u, .thresholds = { 18.0f, 18.0f } };
    const sd_q31_t threshold = sd_given_q31(18.0f, SD_CUSUM_BITS);
    const sd_airpath_config_q31_t fixed_config = { .settle_steps = 20u, .window_steps = 50u, .thresholds = { threshold, threshold } };
    sd_airpath_out_f32_t out = { .phase = 0u };
    sd_airpath_out_q31_t fixed_out = { .phase = 0u };
    uint32_t decided = 0;
    fill_tables(&tables);
    fill_fixed(&tables, &fixed);
    if (!sd_airpath_tables_ok_f32(&tables) || !sd_airpath_tables_ok_q31(&fixed)) { return 1u; }
    sd_airpath_start_f32(&bank);
    sd_airpath_start_q31(&fixed_bank);
    budget_class(not_counted);
    for (uint32_t k = 0; k < 1500u; k++) {
        const sd_airpath_in_f32_t in = sensed(k);
        const sd_airpath_in_q31_t fixed_in = fixed_of(&in);
        sd_airpath_step_f32(&bank, &tables, &config, &in, &out);
        sd_airpath_step_q31(&fixed_bank, &fixed, &fixed_config, &fixed_in, &fixed_out);
        kept = out.residual_kpa[0];
        kept = (float)fixed_out.residual_kpa[0];
        const bool both = (out.phase == (uint8_t)SD_AIRPATH_DECIDES) && (fixed_out.phase == (uint8_t)SD_AIRPATH_DECIDES);
        decided += both ? 1u : 0u;
        budget_class(both ? step : not_counted);
    }
    return (decided > 500u) ? 0u : 1u;
}
