/* SPDX-License-Identifier: MIT */
/// sd_board.h - the emulated boards, QEMU's mps2 family: addresses, interrupts, and the way out by semihosting.
///
/// This header, start.c and mps2.ld are what another board replaces (docs/start/porting.md).
#ifndef SD_BOARD_H
#define SD_BOARD_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Where the emulator loads the calibration page, in ROM, and the events of a bench, in RAM that the image leaves free: a header,
/// then the events.
#define BOARD_PAGE       ((const uint8_t *)0x00200000u)
#define BOARD_PAGE_ROOM  0x00200000u ///< Bytes of ROM from there on.
#define BOARD_EVENTS     ((const void *)0x20200000u)

/// Before the events. RAM is zero where nothing was loaded, so that event_count 0 means that there are none.
typedef struct board_header {
    uint32_t event_count, page_bytes; ///< Events that follow; bytes of the calibration page.
    uint32_t step_q16; ///< How long a tick of the events lasts, in ticks of 40 ns, with 16 bits behind the point.
    uint32_t unused;   ///< Fills the header to 16 bytes.
} board_header_t;

/// Interrupts, numbers of the NVIC.
enum {
    BOARD_IRQ_CAPTURE = 8,  ///< Timer 0: an edge of crank or cam.
    BOARD_IRQ_CLOCK   = 9,  ///< Timer 1: every 10 ms.
    BOARD_IRQ_SAMPLE  = 29, ///< An analogue reading is ready: wideband lambda sensor, pressure.
    BOARD_IRQ_WORK    = 30, ///< Asked for by software: what edges, samples and the clock leave to do.
    BOARD_IRQ_TASK    = 31, ///< Asked for by software: the long part of the 10 ms task.
};

/// Handlers that an image may define; the board's own end the program.
void board_on_capture(void);
void board_on_clock(void);
void board_on_sample(void);
void board_on_work(void);
void board_on_task(void);

/// Lets an interrupt through. priority: 0 (first) to 7.
void board_enable(uint32_t irq, uint32_t priority);
/// Makes an interrupt due now.
void board_pend(uint32_t irq);
/// Timer 0: makes BOARD_IRQ_CAPTURE due once, after so many ticks of 40 ns; at once for 0.
void board_capture_after(uint32_t ticks);
/// Of the handler: the interrupt of timer 0 has been seen.
void board_capture_seen(void);
/// Timer 1: ticks of 40 ns since it was started; wraps.
uint32_t board_now(void);

/// Starts timer 1, and the core's own timer, which counts time down by 40 ns each.
void board_start_ticks(void);
/// Its count, 24 bits.
uint32_t board_ticks(void);

/// Prints a text to the console of the host.
void board_print(const char *text);
void board_figure(const char *name, uint64_t value); ///< "NAME HEX".
/// Ends the program with this exit status; does not return.
void board_exit(uint32_t code);

/// Opens a file of the host, to be read (0) or to be written (1); a negative number when it cannot be.
int32_t board_open(const char *name, int32_t to_be_written);
/// Reads exactly so many bytes; returns how many are missing, 0 when all came.
uint32_t board_read(int32_t file, void *to, uint32_t bytes);
/// Writes; returns how many bytes were not taken.
uint32_t board_write(int32_t file, const void *from, uint32_t bytes);

/// Paints the free stack below the caller, so much of it.
void board_paint_stack(void);
/// Bytes of stack used since, below where it was painted.
uint32_t board_stack_used(void);

#ifdef __cplusplus
}
#endif

#endif
