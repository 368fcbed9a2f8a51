/* SPDX-License-Identifier: MIT */
/* Pieces of a cycle's work in the ecu of fixed point, and its begin; any state in the ranges of fixed_state.h, which both leave behind
 * again. Where the last cycle's work is not done yet, the begin does it piece by piece, so that this is shown by the pieces. Kernels are
 * what contracts_fixed.h says of them. */
/* options: -eva-precision 0 -eva-slevel 12 -eva-min-loop-unroll 26 -eva-slevel-function sd_fixed_begin_work:100 */
/* include: contracts_fixed.h */
/* kernel: firmware/ecu_fixed/sd_fixed_cycle.c firmware/ecu_fixed/sd_fixed_say.c firmware/ecu_fixed/sd_fixed_mixture.c firmware/ecu_fixed/sd_fixed_trims.c firmware/ecu/sd_inputs.c firmware/ecu/sd_publish.c hal/generated/sd_signals.c */
#include "fixed_state.h"

static const sd_port_t port = { 0, 0, send };

static void piece_of(uint8_t piece, uint16_t said) {
    fill_state(true, piece, said);
    sd_ecu_do_piece(&self, &page, &port);
    //@ assert rest: at_rest(&self);
}

static void begin_of(uint8_t piece, uint16_t said, uint8_t shed) {
    const sd_cycle_t cycle = { any_u32(), any_float(-3e38f, 3e38f), any_bool(), any_bool(), any_bool() };
    fill_state(true, piece, said);
    self.shed = shed;
    sd_fixed_begin_work(&self, &page, &port, &cycle);
    //@ assert rest: at_rest(&self);
}

int main(void) {
    fill_page(true);
    for (uint8_t piece = 0; piece <= (uint8_t)SD_FIXED_NONE; piece++) {
        const uint16_t most = (piece == (uint8_t)SD_FIXED_SAY) ? 64u : 0u;
        for (uint16_t said = 0; said <= most; said += SD_PUBLISH_PART) {
            piece_of(piece, said);
            begin_of(piece, said, (uint8_t)any_of(SD_SHED_CYCLE, 255));
        }
    }
    begin_of(SD_FIXED_NONE, 0, SD_SHED_NONE);
    return 0;
}
