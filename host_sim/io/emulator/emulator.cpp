// SPDX-License-Identifier: MIT
#include "io/emulator/emulator.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.hpp"

extern char **environ;

namespace sixdeg {
namespace {

constexpr EmulatedCore kCores[] = {{"cortex-m7", "mps2-an500", "Cortex-M7"},
                                   {"cortex-m4f", "mps2-an386", "Cortex-M4F"},
                                   {"cortex-m3", "mps2-an385", "Cortex-M3, floating point by software"},
                                   {"cortex-m3-fixed", "mps2-an385", "Cortex-M3, ecu of fixed point"}};
constexpr int kSilenceMs = 30000;
constexpr const char *kProgram = "qemu-system-arm";

struct Pipe {
    int read = -1, write = -1;
    Pipe() {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0) throw InputError(kProgram, "", std::strerror(errno));
        read = ends[0], write = ends[1];
    }
};

} // namespace

const EmulatedCore &emulated_core(const std::string &transport) {
    const std::string name = transport.substr(transport.find(':') + 1);
    for (const EmulatedCore &core : kCores)
        if (name == core.preset || "cortex-" + name == core.preset) return core;
    throw InputError("--transport", transport,
                     "no core with an image; allowed: qemu:cortex-m7, qemu:cortex-m4f, qemu:cortex-m3, qemu:cortex-m3-fixed");
}

std::filesystem::path image_of(const EmulatedCore &core) {
    std::error_code failed;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
    for (auto folder = program.parent_path(); folder.has_relative_path(); folder = folder.parent_path()) {
        const auto image = folder / core.preset / "sixdeg_image";
        if (std::filesystem::exists(image, failed)) return image;
    }
    throw InputError(fmt::format("qemu:{}", core.preset), "",
                     fmt::format("its image build/{0}/sixdeg_image is not there; `tools/build {0} sixdeg_image` makes it", core.preset));
}

Emulator::Emulator(const EmulatedCore &core, const EmulatorStart &with) {
    std::signal(SIGPIPE, SIG_IGN); // whether the emulator still listens, write() says
    start(core, with);
    const bool heard = read(&hello_, sizeof hello_) && hello_.magic == SD_LINK_MAGIC;
    const char *const wrong = !heard                                      ? "it has not begun"
                              : hello_.signature != SD_SIGNALS_SIGNATURE  ? "it has another table of signals; build it anew"
                              : hello_.state == SD_LINK_PAGE_REFUSED      ? "it refuses the calibration page; build it anew"
                              : hello_.state == SD_LINK_INIT_REFUSED      ? "its ecu refuses a number of the calibration page"
                                                                          : nullptr;
    if (wrong == nullptr) return;
    const std::string what = fmt::format("{} (`tools/build {} sixdeg_image`)", wrong, core.preset);
    stop();
    throw InputError(with.image.string(), "", what);
}

void Emulator::start(const EmulatedCore &core, const EmulatorStart &with) {
    std::string words[] = {kProgram, "-M", core.board, "-display", "none", "-monitor", "none", "-serial", "none", "-icount",
                           fmt::format("shift={},sleep=off", with.shift),
                           "-semihosting-config", "enable=on,target=native", "-kernel", with.image.string(), "-device",
                           fmt::format("loader,file={},addr=0x200000,force-raw=on", with.page.string())};
    std::string bench_words[] = {"-device", fmt::format("loader,file={},addr=0x20200000,force-raw=on", with.bench.string())};
    std::vector<char *> arguments;
    for (std::string &word : words) arguments.push_back(word.data());
    if (!with.bench.empty())
        for (std::string &word : bench_words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const Pipe asked, answered;
    to_ = asked.write, from_ = answered.read;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, asked.read, 0);
    posix_spawn_file_actions_adddup2(&actions, answered.write, 1);
    posix_spawnattr_t attributes; // a group of its own: the signal that stops this program does not stop the controller
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    const int error = posix_spawnp(&child_, kProgram, &actions, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    ::close(asked.read), ::close(answered.write);
    if (error == 0) return;
    child_ = 0;
    close_pipes();
    throw InputError(kProgram, "", error == ENOENT ? "is not installed; `tools/setup --cross` installs it" : std::strerror(error));
}

void Emulator::close_pipes() {
    if (to_ >= 0) ::close(to_);
    if (from_ >= 0) ::close(from_);
    to_ = from_ = -1;
}

Emulator::~Emulator() { stop(); }

void Emulator::stop() {
    close_pipes();
    if (child_ == 0) return;
    kill(child_, SIGKILL); // it keeps nothing
    waitpid(child_, nullptr, 0);
    child_ = 0;
}

bool Emulator::read(void *to, std::size_t bytes) {
    auto *at = static_cast<char *>(to);
    while (bytes > 0) {
        pollfd waiting{from_, POLLIN, 0};
        const int ready = poll(&waiting, 1, kSilenceMs);
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) return false;
        const ssize_t got = ::read(from_, at, bytes);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got, bytes -= std::size_t(got);
    }
    return true;
}

bool Emulator::write(const void *from, std::size_t bytes) {
    const auto *at = static_cast<const char *>(from);
    while (bytes > 0) {
        const ssize_t put = ::write(to_, at, bytes);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return false;
        at += put, bytes -= std::size_t(put);
    }
    return true;
}

bool Emulator::exchange(const std::vector<sd_event_t> &events, std::vector<EmulatedAnswer> &answers) {
    std::vector<std::uint32_t> asked(1 + events.size() * sizeof(sd_event_t) / 4);
    asked[0] = std::uint32_t(events.size());
    std::memcpy(asked.data() + 1, events.data(), events.size() * sizeof(sd_event_t));
    if (!write(asked.data(), asked.size() * 4)) return false;
    for (std::size_t i = 0; i < events.size(); ++i) {
        EmulatedAnswer answer;
        if (!take(answer) || answer.frame.count == SD_LINK_LAST) return false;
        answers.push_back(std::move(answer));
    }
    return true;
}

bool Emulator::take(EmulatedAnswer &answer) {
    if (!read(&answer.frame, sizeof answer.frame)) return false;
    if (answer.frame.count == SD_LINK_LAST) return true;
    answer.said.resize(answer.frame.count);
    return read(answer.said.data(), answer.said.size() * sizeof(sd_event_t));
}

bool Emulator::take_bench(std::vector<EmulatedAnswer> &answers, sd_link_end_t &end) {
    EmulatedAnswer answer;
    while (take(answer)) {
        if (answer.frame.count == SD_LINK_LAST) return read(&end, sizeof end);
        answers.push_back(std::move(answer));
        answer = {};
    }
    return false;
}

bool Emulator::finish(sd_link_end_t &end) {
    const std::uint32_t nothing = 0;
    EmulatedAnswer last;
    return write(&nothing, sizeof nothing) && take(last) && last.frame.count == SD_LINK_LAST && read(&end, sizeof end);
}

} // namespace sixdeg
