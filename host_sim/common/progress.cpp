// SPDX-License-Identifier: MIT
#include "common/progress.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <fmt/format.h>
#include <mutex>
#include <sys/ioctl.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "common/stop.hpp"

namespace sixdeg {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kFirst{1000}, kRedraw{200};
constexpr int kBarColumns = 24, kUsualColumns = 80;
constexpr const char *kErase = "\r\033[K";

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

std::string duration(double seconds) {
    if (seconds < 100) return fmt::format("{:.0f} s", seconds);
    return seconds < 6000 ? fmt::format("{:.0f} min", seconds / 60) : fmt::format("{:.1f} h", seconds / 3600);
}

std::size_t columns() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : kUsualColumns;
}

void write_all(int file, std::string_view text) {
    while (!text.empty()) {
        const ssize_t wrote = ::write(file, text.data(), text.size());
        if (wrote <= 0) return; // nobody to tell
        text.remove_prefix(std::size_t(wrote));
    }
}

/// Signals stay with the thread that works: it may wait for one in a system call.
class SignalsBlocked {
  public:
    SignalsBlocked() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

  private:
    sigset_t before_{};
};

} // namespace

/// The line itself, and who draws it.
class ProgressLine {
  public:
    static ProgressLine &the() {
        static ProgressLine line;
        return line;
    }

    void begin(const Progress &stage) {
        const std::lock_guard lock(mutex_);
        stages_.push_back(&stage);
        if (stages_.size() > 1 || isatty(STDERR_FILENO) == 0) return;
        done_ = false;
        for (Stream *stream : {&output_, &errors_}) take_over(*stream);
        const SignalsBlocked here;
        drawer_ = std::thread([this] { draw_until_done(); });
    }

    void end(const Progress &stage) {
        {
            const std::lock_guard lock(mutex_);
            stages_.erase(std::remove(stages_.begin(), stages_.end(), &stage), stages_.end());
            if (!stages_.empty() || !drawer_.joinable()) return;
            done_ = true;
        }
        changed_.notify_all();
        drawer_.join();
        for (Stream *stream : {&output_, &errors_}) give_back(*stream);
    }

  private:
    /// A stream of the C library that leads to a terminal: what is printed to it must erase the line first.
    struct Stream {
        std::FILE **name;
        int file;
        std::FILE *before = nullptr;
    };

    void take_over(Stream &stream) {
        if (isatty(stream.file) == 0) return;
        std::fflush(*stream.name);
        cookie_io_functions_t functions{};
        functions.write = stream.file == STDOUT_FILENO ? write_above<STDOUT_FILENO> : write_above<STDERR_FILENO>;
        std::FILE *instead = fopencookie(this, "w", functions);
        if (!instead) return;
        std::setvbuf(instead, nullptr, _IOLBF, BUFSIZ);
        stream.before = *stream.name, *stream.name = instead;
    }

    static void give_back(Stream &stream) {
        if (!stream.before) return;
        std::fclose(*stream.name); // what is left in it is written
        *stream.name = stream.before, stream.before = nullptr;
    }

    template <int file> static ssize_t write_above(void *line, const char *text, std::size_t size) {
        auto &self = *static_cast<ProgressLine *>(line);
        const std::lock_guard lock(self.mutex_);
        self.erase();
        write_all(file, {text, size});
        if (size > 0) self.amid_line_ = text[size - 1] != '\n';
        return ssize_t(size);
    }

    void erase() {
        if (drawn_) write_all(STDERR_FILENO, kErase);
        drawn_ = false;
    }

    void draw_until_done() {
        std::unique_lock lock(mutex_);
        for (auto wait = kFirst; !changed_.wait_for(lock, wait, [this] { return done_; }); wait = kRedraw) {
            if (stop_signal() != 0) erase(); // the command is about to leave, and what it says then is its last
            if (stop_signal() != 0 || amid_line_) continue; // half a line of the command's own stands there
            write_all(STDERR_FILENO, kErase + text().substr(0, columns() - 1));
            drawn_ = true;
        }
        erase();
    }

    std::string text() const {
        std::string words;
        const Progress *shown = nullptr;
        for (const Progress *stage : stages_) {
            if (stage->total_ == 1 && stage->kind_ == Progress::counted) continue; // one of one tells nothing
            words += (words.empty() ? "" : ": ") + stage->name_;
            if (stage->total_ > (stage->kind_ == Progress::counted ? 1 : 0)) {
                shown = stage;
                break;
            }
        }
        if (!shown) return words + ", " + duration(now_s() - stages_.front()->began_s_);
        const double done = shown->done_.load(std::memory_order_relaxed), share = std::clamp(done / shown->total_, 0.0, 1.0);
        if (shown->kind_ == Progress::counted) words += fmt::format(" {:.0f} of {:.0f}", std::min(done + 1, shown->total_), shown->total_);
        const int filled = int(share * kBarColumns);
        words += fmt::format(" [{:#<{}}{:.<{}}] {:.0f} %", "", filled, "", kBarColumns - filled, 100 * share);
        const double since_s = now_s() - shown->began_s_;
        return words + (share > 0 ? ", " + duration(since_s * (1 - share) / share) + " left" : "");
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<const Progress *> stages_;
    Stream output_{&stdout, STDOUT_FILENO}, errors_{&stderr, STDERR_FILENO};
    std::thread drawer_;
    bool done_ = false, drawn_ = false, amid_line_ = false;
};

Progress::Progress(std::string name, double total, Kind kind)
    : name_(std::move(name)), total_(total), kind_(kind), began_s_(now_s()) {
    ProgressLine::the().begin(*this);
}

Progress::~Progress() { ProgressLine::the().end(*this); }

} // namespace sixdeg
