// SPDX-License-Identifier: MIT
#include "loop/bus_feed.hpp"

#include <fmt/format.h>
#include <thread>

#include "common/error.hpp"
#include "common/stop.hpp"

namespace sixdeg {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kSearch{5000}, kSilence{2000}, kAskAgain{50}, kBeat{10};

int left_ms(std::chrono::steady_clock::time_point until) {
    const auto left = std::chrono::ceil<milliseconds>(until - std::chrono::steady_clock::now());
    return int(std::max<long>(0, left.count()));
}

} // namespace

BusFeed::BusFeed(Bus &bus, double tick_hz, Pace pace, EventListener listener)
    : EcuFeed(tick_hz), bus_(bus), port_(bus.port()), tick_hz_(tick_hz), pace_(pace),
      listener_(std::move(listener)) {
    find_ecu();
}

void BusFeed::find_ecu() {
    const auto until = Clock::now() + kSearch;
    while (stop_signal() == 0 && Clock::now() < until) {
        bus_.claim({SD_CLAIM_WHO, SD_SIGNALS_SIGNATURE});
        const auto ask_again = Clock::now() + kAskAgain;
        while (Clock::now() < ask_again) {
            sd_event_t event;
            bus_.wait(left_ms(ask_again));
            while (port_.receive(port_.context, &event, 1) == 1) {
            }
            const auto claim = bus_.heard_claim();
            if (!claim || claim->id != SD_CLAIM_RUNNING) continue;
            if (claim->signature == SD_SIGNALS_SIGNATURE) return;
            throw InputError(
                "ecu", "",
                fmt::format(
                    "it has another table of signals ({:08x}, here {:08x}); build both from one source",
                    claim->signature, SD_SIGNALS_SIGNATURE));
        }
    }
    if (stop_signal() == 0)
        throw InputError("ecu", "", "none answers; start `sixdeg ecu ENGINE.toml --transport ...`");
}

void BusFeed::put(const sd_event_t &event) {
    for (int tries = 0; port_.send(port_.context, &event, 1) == 0; ++tries) {
        if (tries == 20) { // the other side has not read for a while
            ++dropped_;
            return;
        }
        bus_.wait(1);
    }
    if (listener_) listener_(false, event);
}

void BusFeed::send(const sd_event_t &event) {
    if (event.kind == SD_EVENT_TIME && (pace_.real_time || pace_.at_most > 0)) wait_until_due(event.tick);
    const auto asked = Clock::now();
    put(event);
    if (event.kind == SD_EVENT_TIME) note(await_answer(event, asked));
}

void BusFeed::wait_until_due(std::uint32_t tick) {
    if (!started_) {
        start_ = Clock::now();
        last_tick_ = tick;
        started_ = true;
    }
    simulated_s_ += std::int32_t(tick - last_tick_) / tick_hz_;
    last_tick_ = tick;
    const std::chrono::duration<double> after(pace_.real_time ? simulated_s_ : simulated_s_ / pace_.at_most);
    due_ = start_ + std::chrono::duration_cast<Clock::duration>(after);
    while (stop_signal() == 0 && Clock::now() < due_) std::this_thread::sleep_until(due_);
}

bool BusFeed::take_answers(std::uint32_t tick) {
    bool answered = false;
    sd_event_t event;
    while (!answered && port_.receive(port_.context, &event, 1) == 1) {
        if (listener_) listener_(true, event);
        hear(event);
        answered = event.kind == SD_EVENT_DONE && event.tick == tick;
    }
    return answered;
}

bool BusFeed::await_answer(const sd_event_t &time, Clock::time_point asked) {
    const auto until =
        pace_.real_time ? std::max(due_ + kBeat, asked) : asked + (silent_ ? kBeat : kSilence);
    auto ask_again = asked + kAskAgain;
    while (!take_answers(time.tick)) {
        const auto now = Clock::now();
        if (now >= until) return false; // also when a signal came: what was said belongs into the files
        if (now >= ask_again && !pace_.real_time) {
            port_.send(port_.context, &time, 1);
            ask_again = now + kAskAgain;
        }
        bus_.wait(std::min(left_ms(until), left_ms(ask_again) + 1));
    }
    round_trips_us_.push_back(std::chrono::duration<float, std::micro>(Clock::now() - asked).count());
    return true;
}

void BusFeed::note(bool answered) {
    if (!answered && pace_.real_time) ++missed_;
    if (!answered && !silent_) {
        silent_ = !pace_.real_time || ++silent_beats_ > kSilence / kBeat;
        silences_ += silent_;
        if (silent_) say("does not answer; the plant goes on without it");
    }
    if (answered) {
        silent_beats_ = 0;
        if (silent_) say("answers again");
        silent_ = false;
    }
    if (bus_.peer_starts() != starts_seen_) {
        starts_seen_ = bus_.peer_starts();
        ++restarts_;
        say("has been started anew");
    }
}

void BusFeed::say(const char *what) const { fmt::print(stderr, "sixdeg plant: the ecu {}\n", what); }

} // namespace sixdeg
