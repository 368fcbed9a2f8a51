/* SPDX-License-Identifier: MIT */
#include "sd_nuio.h"

#define STATES ((uint32_t)SD_NUIO_STATES)

void sd_nuio_begin(sd_nuio_t *self, const sd_nuio_table_t *table, const float *x) {
    for (uint32_t i = 0; i < STATES; ++i) { self->z[i] = x[i] + table->e[i][0] * x[0] + table->e[i][1] * x[3]; }
}

void sd_nuio_look(const sd_nuio_t *self, const sd_nuio_table_t *table, const float *y, sd_nuio_estimate_t *out) {
    for (uint32_t i = 0; i < STATES; ++i) { out->x[i] = self->z[i] - table->e[i][0] * y[0] - table->e[i][1] * y[1]; }
    out->innovation[0] = y[0] - out->x[0];
    out->innovation[1] = y[1] - out->x[3];
    out->residual = table->gamma[0] * out->innovation[0] + table->gamma[1] * out->innovation[1];
}

void sd_nuio_step(sd_nuio_t *self, const sd_nuio_table_t *table, const sd_nuio_estimate_t *at, const float *rate, float share,
    float period_s) {
    for (uint32_t i = 0; i < STATES; ++i) {
        const float *m = table->m[i], *k = table->k[i], *more = table->more[i];
        const float by_model = m[0] * rate[0] + m[1] * rate[1] + m[2] * rate[2] + m[3] * rate[3];
        const float by_output = (k[0] + share * more[0]) * at->innovation[0] + (k[1] + share * more[1]) * at->innovation[1];
        self->z[i] += period_s * (by_model + by_output);
    }
}
