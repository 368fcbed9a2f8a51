/* SPDX-License-Identifier: MIT */
/* From reset to main, and the way out: messages and the exit code go to the emulator by semihosting. */
#include "board.h"

extern uint32_t stack_top[], data_from[], data_to[], data_end[], bss_to[], bss_end[];
int main(void);
void reset(void);
static void fault(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault,
};

enum { SYS_WRITE0 = 0x04, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

static void semihost(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void board_print(const char *text) { semihost(SYS_WRITE0, text); }

void board_exit(uint32_t code) {
    const uint32_t block[2] = { APPLICATION_EXIT, code };
    semihost(SYS_EXIT_EXTENDED, block);
    for (;;) {}
}

static void fault(void) {
    board_print("fault\n");
    board_exit(9u);
}

void board_figure(const char *name, uint64_t value) {
    char digits[19];
    uint32_t at = sizeof digits;
    digits[--at] = 0;
    digits[--at] = '\n';
    do {
        digits[--at] = "0123456789abcdef"[value & 15u];
        value >>= 4;
    } while (value != 0u);
    board_print(name);
    board_print(" ");
    board_print(&digits[at]);
}

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
