// SPDX-License-Identifier: MIT
// An ecu at the other end of a bus.
//
// Lock-step: a time event waits for its answer, however long that takes; a frame that was lost is asked for again.
// Real time: a time event waits for its hour, and its answer has until the next one. Who does not answer for two
// seconds is silent: the run goes on at the pace of time, and says so when the ecu is back.
#pragma once
#include <chrono>

#include "io/bus/bus.hpp"
#include "io/log/port_tap.hpp"
#include "io/events/ecu_feed.hpp"

namespace sixdeg {

/// `at_most`: times real time, in lock-step; 0: no limit.
struct Pace {
    bool real_time = false;
    double at_most = 0;
};

class BusFeed : public EcuFeed {
  public:
    /// Asks who is there; throws InputError when for some seconds no ecu of the same signal table answers.
    BusFeed(Bus &bus, double tick_hz, Pace pace, EventListener listener = {});

    void send(const sd_event_t &event) override;

    std::size_t silences() const { return silences_; }      ///< Times the ecu fell silent.
    std::size_t restarts() const { return restarts_; }      ///< Times it came back as another process.
    std::size_t missed() const { return missed_; }          ///< Real time: clock events not answered in time.
    std::size_t dropped() const { return dropped_; }        ///< Events that the bus would not take.
    const std::vector<float> &round_trips_us() const { return round_trips_us_; } ///< By answered clock event, from before it is sent.

  private:
    using Clock = std::chrono::steady_clock;
    void find_ecu();
    void put(const sd_event_t &event);
    void wait_until_due(std::uint32_t tick);
    bool await_answer(const sd_event_t &time, Clock::time_point asked);
    bool take_answers(std::uint32_t tick);
    void note(bool answered);
    void say(const char *what) const;

    Bus &bus_;
    sd_port_t port_;
    double tick_hz_;
    Pace pace_;
    EventListener listener_;
    Clock::time_point start_{}, due_{};
    std::uint32_t last_tick_ = 0;
    double simulated_s_ = 0;
    bool started_ = false, silent_ = false;
    int silent_beats_ = 0;
    std::uint32_t starts_seen_ = 0;
    std::size_t silences_ = 0, restarts_ = 0, missed_ = 0, dropped_ = 0;
    std::vector<float> round_trips_us_;
};

} // namespace sixdeg
