/* SPDX-License-Identifier: MIT */
/* The air path's diagnosis at one point of a six-cylinder diesel, with numbers as a design makes them. */
#include "board.h"
#include "budget_blocks.h"
#include "sd_airpath_bank.h"

static volatile float kept;

static void fill_model(sd_airpath_model_t *m) {
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

static void fill_tables(sd_airpath_tables_t *t) {
    t->present = 1u, t->period_s = 0.01f, t->emptying_low_ps = 3.0f, t->emptying_high_ps = 6.0f, t->fault[0] = 4.6f, t->fault[1] = 1.7f;
    fill_model(&t->model);
    for (uint32_t o = 0; o < SD_AIRPATH_OBSERVERS; o++) {
        sd_nuio_table_t *n = &t->observer[o];
        for (uint32_t i = 0; i < SD_NUIO_STATES; i++) { n->m[i][i] = 1.0f; }
        n->m[3][3] = 0.0f, n->e[3][1] = -1.0f, n->k[0][0] = 3.0f, n->k[3][1] = 5.0f, n->more[0][0] = -1.0f, n->gamma[0] = 1.0f;
    }
    t->cusum.hypotheses = 4u, t->cusum.residuals = 2u;
    for (uint32_t l = 0; l < 4u; l++) {
        t->cusum.weight[l][(l < 2u) ? 1 : 0] = (l % 2u == 0u) ? 1.0f : -1.0f;
        t->cusum.offset[l] = 0.5f, t->cusum.group[l] = (uint8_t)(l / 2u);
    }
}

uint32_t budget_count_airpath(uint32_t not_counted, uint32_t step) {
    static sd_airpath_tables_t tables;
    static sd_airpath_bank_t bank;
    const sd_airpath_config_t config = { .settle_steps = 20u, .window_steps = 50u, .thresholds = { 18.0f, 18.0f } };
    sd_airpath_out_t out = { .phase = 0u };
    uint32_t decided = 0;
    fill_tables(&tables);
    if (!sd_airpath_tables_ok(&tables)) { return 1u; }
    sd_airpath_start(&bank);
    budget_class(not_counted);
    for (uint32_t k = 0; k < 1500u; k++) {
        const float noise = (float)((k * 7u) & 15u) / 16.0f - 0.5f;
        const sd_airpath_in_t in = { .speed_rpm = 1500.0f + noise, .air_gps = 113.0f, .fuel_gps = 7.0f, .charge_k = 310.0f, .egr_k = 370.0f,
                                     .exhaust_k = 720.0f, .egr_opening = 0.35f, .vgt_position = 0.44f, .intake_kpa = 153.4f + noise,
                                     .exhaust_kpa = 174.0f - 2.0f * noise };
        sd_airpath_step(&bank, &tables, &config, &in, &out);
        kept = out.residual_kpa[0];
        decided += (out.phase == (uint8_t)SD_AIRPATH_DECIDES) ? 1u : 0u;
        budget_class((out.phase == (uint8_t)SD_AIRPATH_DECIDES) ? step : not_counted);
    }
    return (decided > 500u) ? 0u : 1u;
}
