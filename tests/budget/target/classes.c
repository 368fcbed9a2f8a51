/* SPDX-License-Identifier: MIT */
/* The plugin sees only addresses, so each class is a function of its own. */
#include "board.h"

#define CLASS(N)                                                                                                       \
    void budget_class_##N(void);                                                                                       \
    __attribute__((noinline, used, section(".text.class_" #N))) void budget_class_##N(void) { __asm volatile("nop"); }
CLASS(0) CLASS(1) CLASS(2) CLASS(3) CLASS(4) CLASS(5) CLASS(6) CLASS(7)
CLASS(8) CLASS(9) CLASS(10) CLASS(11) CLASS(12) CLASS(13) CLASS(14) CLASS(15)
CLASS(16) CLASS(17) CLASS(18) CLASS(19) CLASS(20) CLASS(21) CLASS(22) CLASS(23)

void budget_class(uint32_t event_class) {
    static void (*const classes[BUDGET_CLASSES])(void) = {
        budget_class_0, budget_class_1, budget_class_2, budget_class_3,
        budget_class_4, budget_class_5, budget_class_6, budget_class_7,
        budget_class_8, budget_class_9, budget_class_10, budget_class_11,
        budget_class_12, budget_class_13, budget_class_14, budget_class_15,
        budget_class_16, budget_class_17, budget_class_18, budget_class_19,
        budget_class_20, budget_class_21, budget_class_22, budget_class_23,
    };
    if (event_class >= BUDGET_CLASSES) {
        board_print("more classes than the plugin knows\n");
        board_exit(4u);
    }
    classes[event_class]();
}
