/* SPDX-License-Identifier: MIT */
/* The plugin sees only addresses, so each class is a function of its own. */
#include "board.h"

#define CLASS(N)                                                                                                       \
    void budget_class_##N(void);                                                                                       \
    __attribute__((noinline, used, section(".text.class_" #N))) void budget_class_##N(void) { __asm volatile("nop"); }
CLASS(0) CLASS(1) CLASS(2) CLASS(3) CLASS(4) CLASS(5) CLASS(6) CLASS(7)
CLASS(8) CLASS(9) CLASS(10) CLASS(11) CLASS(12) CLASS(13) CLASS(14) CLASS(15)

void budget_class(uint32_t event_class) {
    static void (*const classes[16])(void) = {
        budget_class_0, budget_class_1, budget_class_2, budget_class_3,
        budget_class_4, budget_class_5, budget_class_6, budget_class_7,
        budget_class_8, budget_class_9, budget_class_10, budget_class_11,
        budget_class_12, budget_class_13, budget_class_14, budget_class_15,
    };
    classes[event_class & 15u]();
}
