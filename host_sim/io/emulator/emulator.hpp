// SPDX-License-Identifier: MIT
// A controller on an emulated board: QEMU with the firmware's image, and the pipes to it (hal/cortexm/sd_link.h).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

extern "C" {
#include "sd_calibration.h"
#include "sd_link.h"
}

namespace sixdeg {

/// A core that there is an image for.
struct EmulatedCore {
    const char *preset;    ///< Of CMakePresets.json; the image is in build/PRESET.
    const char *board;     ///< QEMU's name.
    const char *name;      ///< For people.
};

/// The core of `qemu:PRESET` or one of its short names (m7, m4f, m3, m3-fixed). Throws InputError, which lists them.
const EmulatedCore &emulated_core(const std::string &transport);

/// Its image, beside this program's own preset. Throws InputError when it is not there, and says how to make it.
std::filesystem::path image_of(const EmulatedCore &core);

/// What the emulated controller is given.
struct EmulatorStart {
    std::filesystem::path image;
    std::filesystem::path page;  ///< File of the calibration page, which lies in the controller's flash.
    std::filesystem::path bench; ///< File of events that happen at their own times (sd_board.h); empty: the host names them.
    int shift = 10; ///< An instruction takes 2^shift ns of the controller's time. With 10 its timer, 40 ns a tick, counts single ones.
};

/// What an ecu said to one event.
struct EmulatedAnswer {
    sd_link_frame_t frame{};
    std::vector<sd_event_t> said;
};

/// One life of the emulated controller. Neither copied nor moved.
class Emulator {
  public:
    /// Starts it; its files stay while this object lives. Throws InputError when the emulator is not installed, cannot be started, or its
    /// image refuses the page.
    Emulator(const EmulatedCore &core, const EmulatorStart &with);
    ~Emulator();
    Emulator(const Emulator &) = delete;
    Emulator &operator=(const Emulator &) = delete;

    /// Hands over at most SD_LINK_EVENTS events and takes the answers to all of them. False when the emulator has ended, was killed or
    /// has said nothing for 30 s: `answers` then holds what came before.
    bool exchange(const std::vector<sd_event_t> &events, std::vector<EmulatedAnswer> &answers);
    /// With a bench: takes the answers until all of its events have happened. False as in exchange.
    bool take_bench(std::vector<EmulatedAnswer> &answers, sd_link_end_t &end);
    /// Ends it in good order; false when it does not answer.
    bool finish(sd_link_end_t &end);
    const sd_link_hello_t &hello() const { return hello_; }
    pid_t process() const { return child_; }

  private:
    void start(const EmulatedCore &core, const EmulatorStart &with);
    bool take(EmulatedAnswer &answer);
    bool read(void *to, std::size_t bytes);
    bool write(const void *from, std::size_t bytes);
    void close_pipes();
    void stop();

    pid_t child_ = 0;
    int to_ = -1, from_ = -1;
    sd_link_hello_t hello_{};
};

} // namespace sixdeg
