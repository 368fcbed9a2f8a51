/* SPDX-License-Identifier: MIT */
/* From reset to main, and the vectors. */
#include "sd_board.h"

extern uint32_t stack_top[], data_from[], data_to[], data_end[], bss_to[], bss_end[];
int main(void);
void reset(void);

static void fault(void) {
    board_print("fault\n");
    board_exit(9u);
}

#define IRQS 32u
#define HANDLER(NAME) \
    void NAME(void) __attribute__((weak, alias("unused")))
void unused(void);
void unused(void) {
    board_print("an interrupt that nobody handles\n");
    board_exit(8u);
}
HANDLER(board_on_capture);
HANDLER(board_on_clock);
HANDLER(board_on_sample);
HANDLER(board_on_work);
HANDLER(board_on_task);

__attribute__((section(".vectors"), used)) static const void *const vectors[16u + IRQS] = {
    stack_top, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault,
    [16 + BOARD_IRQ_CAPTURE] = (const void *)board_on_capture,
    [16 + BOARD_IRQ_CLOCK] = (const void *)board_on_clock,
    [16 + BOARD_IRQ_SAMPLE] = (const void *)board_on_sample,
    [16 + BOARD_IRQ_WORK] = (const void *)board_on_work,
    [16 + BOARD_IRQ_TASK] = (const void *)board_on_task,
};

__attribute__((noreturn)) void reset(void) {
    for (uint32_t *to = data_to, *from = data_from; to < data_end;) { *to++ = *from++; }
    for (uint32_t *to = bss_to; to < bss_end;) { *to++ = 0; }
#ifdef __ARM_FP
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: the floating-point unit */
    __asm volatile("dsb\nisb");
#endif
    board_exit((uint32_t)main());
    for (;;) {}
}
