/* SPDX-License-Identifier: MIT */
/* What the emulated board offers: interrupts, a timer, semihosting, and how much stack was used. */
#include "sd_board.h"

#include <stddef.h>

#define STACK_WORDS 8192u
#define PAINT       0xdeadbeefu

/* ---- interrupts and time ------------------------------------------------------------------------------------------- */

static volatile uint32_t *word_at(uint32_t address) { return (volatile uint32_t *)(uintptr_t)address; }

void board_enable(uint32_t irq, uint32_t priority) {
    ((volatile uint8_t *)(uintptr_t)0xE000E400u)[irq] = (uint8_t)(priority << 5); /* NVIC_IPR: the upper three bits count */
    *word_at(0xE000E100u) = 1u << irq;                                           /* NVIC_ISER */
}

void board_pend(uint32_t irq) {
    *word_at(0xE000E200u) = 1u << irq; /* NVIC_ISPR */
    __asm volatile("dsb\nisb" ::: "memory");
}

/* The board's two timers count down by 40 ns. */
enum { CTRL = 0x0, VALUE = 0x4, RELOAD = 0x8, INTCLEAR = 0xC, ENABLE = 1, INTERRUPT = 8 };
static volatile uint32_t *timer(uint32_t number, uint32_t word) { return word_at(0x40000000u + 0x1000u * number + word); }

void board_capture_after(uint32_t ticks) {
    if (ticks == 0u) {
        board_pend(BOARD_IRQ_CAPTURE);
        return;
    }
    *timer(0, CTRL) = 0;
    *timer(0, RELOAD) = ticks; /* which restarts the count */
    *timer(0, VALUE) = ticks;
    *timer(0, CTRL) = ENABLE | INTERRUPT;
}

void board_capture_seen(void) {
    *timer(0, CTRL) = 0;
    *timer(0, INTCLEAR) = 1;
}

uint32_t board_now(void) { return 0xFFFFFFFFu - *timer(1, VALUE); }

void board_start_ticks(void) {
    *timer(1, RELOAD) = 0xFFFFFFFFu;
    *timer(1, VALUE) = 0xFFFFFFFFu;
    *timer(1, CTRL) = ENABLE;
    *word_at(0xE000E014u) = 0x00FFFFFFu; /* SYST_RVR */
    *word_at(0xE000E018u) = 0;           /* SYST_CVR */
    *word_at(0xE000E010u) = 5u;          /* SYST_CSR: on, the core's clock, no interrupt */
}

uint32_t board_ticks(void) { return *word_at(0xE000E018u); }

/* ---- semihosting --------------------------------------------------------------------------------------------------- */

enum { SYS_OPEN = 0x01, SYS_WRITE0 = 0x04, SYS_WRITE = 0x05, SYS_READ = 0x06, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };
enum { MODE_READ = 1, MODE_WRITE = 5 }; /* as fopen's "rb" and "wb" */

static uint32_t semihost(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_print(const char *text) { (void)semihost(SYS_WRITE0, text); }

void board_exit(uint32_t code) {
    const uint32_t block[2] = { APPLICATION_EXIT, code };
    (void)semihost(SYS_EXIT_EXTENDED, block);
    for (;;) {}
}

int32_t board_open(const char *name, int32_t to_be_written) {
    uint32_t length = 0;
    while (name[length] != '\0') { length++; }
    const uint32_t block[3] = { (uint32_t)(uintptr_t)name, (to_be_written != 0) ? MODE_WRITE : MODE_READ, length };
    return (int32_t)semihost(SYS_OPEN, block);
}

static uint32_t moved(uint32_t operation, int32_t file, uintptr_t memory, uint32_t bytes) {
    const uint32_t block[3] = { (uint32_t)file, (uint32_t)memory, bytes };
    return semihost(operation, block);
}

/* Semihosting says how many bytes are left. */
uint32_t board_read(int32_t file, void *to, uint32_t bytes) {
    uintptr_t at = (uintptr_t)to;
    while (bytes > 0u) {
        const uint32_t left = moved(SYS_READ, file, at, bytes);
        if (left >= bytes) { break; } /* the end of the file, or an error */
        at += bytes - left;
        bytes = left;
    }
    return bytes;
}

uint32_t board_write(int32_t file, const void *from, uint32_t bytes) {
    uintptr_t at = (uintptr_t)from;
    while (bytes > 0u) {
        const uint32_t left = moved(SYS_WRITE, file, at, bytes);
        if (left >= bytes) { break; }
        at += bytes - left;
        bytes = left;
    }
    return bytes;
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

/* ---- the stack ----------------------------------------------------------------------------------------------------- */

static uint32_t *painted;

__attribute__((noinline)) void board_paint_stack(void) {
    uint32_t *here;
    __asm volatile("mov %0, sp" : "=r"(here));
    for (uint32_t *word = here - STACK_WORDS; word < here - 8; word++) { *(volatile uint32_t *)word = PAINT; }
    painted = here;
}

__attribute__((noinline)) uint32_t board_stack_used(void) {
    const volatile uint32_t *word = painted - STACK_WORDS;
    while (*word == PAINT) { word++; }
    return (uint32_t)(painted - (uint32_t *)(uintptr_t)word) * 4u;
}
