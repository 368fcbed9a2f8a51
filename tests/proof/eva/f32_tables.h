/* SPDX-License-Identifier: MIT */
/// f32_tables.h - the page's tables of filters, motion and patterns: sizes are those of one engine and its wheel, as init takes them, and
/// what a row says of firings and valves is in range for them; all the other numbers are any bits, NaN included.
#ifndef SD_PROOF_F32_TABLES_H
#define SD_PROOF_F32_TABLES_H
#include "any.h"
#include "sd_motion.h"

typedef struct engine {
    uint32_t positions, coefficients, firings, modes, speeds, window, learns; /* learns: 1: a pattern while it fires */
} engine_t;

static sd_kalman_tables_t tables;

static void fill_rows(const engine_t *e) {
    //@ loop unroll 120;
    for (uint32_t k = 0; k < 2u * e->positions; k++) {
        sd_kalman_word_t *word = &tables.pool[k * tables.row_words];
        word->at.first = (uint8_t)any_upto(e->coefficients - 2u), word->at.close = (uint8_t)any_upto((1u << tables.cylinders) - 1u);
        word->at.read = (uint8_t)any_upto(e->firings), word->at.tooth = (uint8_t)any_upto(1u);
    }
}

static void fill_tables(const engine_t *e) {
    ANY_BYTES(tables);
    tables.positions = (uint8_t)e->positions, tables.coefficients = (uint8_t)e->coefficients, tables.speeds = (uint8_t)e->speeds;
    tables.sets = 2, tables.firings = (uint8_t)e->firings, tables.cylinders = (uint8_t)((e->firings > 0u) ? e->firings : 4u);
    tables.modes = (uint8_t)e->modes, tables.shapes = (e->firings > 0u) ? 1 : 0, tables.window = (uint8_t)e->window;
    tables.teeth = (uint8_t)(e->positions - 2u);
    tables.parts = (uint8_t)((e->learns != 0u) ? 3u + e->firings : 0u), tables.hidden = (uint8_t)((e->learns != 0u) ? e->firings / 2u : 0u);
    tables.gains_at = (uint16_t)sd_motion_gains_at(&tables), tables.row_words = (uint16_t)sd_motion_row_words(&tables);
    fill_rows(e);
}

#endif
