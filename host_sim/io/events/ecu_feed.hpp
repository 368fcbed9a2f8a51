// SPDX-License-Identifier: MIT
// An ecu as a host sees it, wherever it runs: events go in, in order of time; what it says comes back.
#pragma once
#include <array>
#include <bitset>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

extern "C" {
#include "hal.h"
#include "sd_crank.h"
#include "sd_signals.h"
#include "sd_status.h"
}

namespace sixdeg {

/// The latest of what an ecu said.
class EcuSaid {
  public:
    /// Returns true when the event completes the row of a cycle: it has ended, and signals() holds all of it. The row may
    /// come in pieces, some teeth after the one that ended the cycle.
    bool take(const sd_event_t &event);
    /// Nothing is known of what it says now.
    void distrust();

    const sd_signals_t &signals() const { return signals_; }
    std::uint8_t health(sd_owner_t owner) const { return health_[owner]; }
    /// Of the tooth that ended the last cycle heard whole.
    std::uint32_t cycle_tick() const { return cycle_tick_; }
    std::size_t sync_losses() const { return sync_losses_; }
    /// Firings said so far; signals() holds the last one.
    std::size_t firings() const { return firings_; }
    /// The same of the rows on the work of a cycle.
    std::size_t works() const { return works_; }

  private:
    sd_signals_t signals_{};
    std::uint8_t health_[SD_OWNER_COUNT] = {};
    bool completes_cycle(const sd_event_t &event);

    std::bitset<SD_SIGNAL_COUNT> gathered_; ///< Of the cycle whose row is coming in.
    std::uint32_t gathering_tick_ = 0, cycle_tick_ = 0;
    bool synced_ = false;
    std::size_t sync_losses_ = 0, firings_ = 0, works_ = 0;
};

/// Where events go.
class EcuFeed {
  public:
    explicit EcuFeed(double tick_hz) : tick_hz_(tick_hz) {}
    virtual ~EcuFeed() = default;

    virtual void send(const sd_event_t &event) = 0;
    /// What a sampled sensor shows from now on; it is read every 10 ms, right before the time event.
    void show(sd_input_t input, double value) { shown_[input] = float(value); }
    /// One reading of a sampled sensor at t_s: for those that are read more often.
    void sample(sd_input_t input, double value, double t_s);
    /// Sends the time event that falls due every 10 ms before t_s; the first call sets where they begin.
    void tell_time_until(double t_s);
    /// The ecu begins anew, as after a reset: what it had learned is lost, and events sent before are handled. A feed whose ecu is not
    /// in its hands does nothing.
    virtual void restart() {}
    /// restart() right after the first time event at or after t_s.
    void restart_at(double t_s) { restart_at_s_ = t_s; }
    /// The time event that ends a run.
    void finish(double t_s);
    /// Time events sent. Whatever was caused before the last one has been said, or is lost.
    std::size_t clock_events() const { return clock_events_; }
    /// Capture tick of a time, modulo 2^32.
    std::uint32_t tick_at(double t_s) const;
    /// Appends what the ecu says from now on to `sink` (caller-owned, outlives the feed); nullptr ends it.
    void record_answers(std::vector<sd_event_t> *sink) { sink_ = sink; }

  protected:
    void hear(const sd_event_t &event) {
        if (sink_) sink_->push_back(event);
    }

  private:
    void read_sensors(std::uint32_t tick);
    void tell_time(double t_s);

    double tick_hz_;
    std::optional<double> next_time_s_, restart_at_s_;
    std::size_t clock_events_ = 0;
    std::array<std::optional<float>, SD_INPUT_COUNT> shown_{};
    std::vector<sd_event_t> *sink_ = nullptr;
};

/// Which answers belong to which edge, when they come in batches and some never do.
class Answers {
  public:
    void add(const std::vector<sd_event_t> &events) { waiting_.insert(waiting_.end(), events.begin(), events.end()); }
    /// Takes in all that was said up to the answer to the edge at `tick`. Without a whole answer it takes
    /// nothing but distrust, and counts. Returns true when a cycle's row was complete with it.
    bool take(std::uint32_t tick, EcuSaid &said);
    /// Takes in the rest.
    void take_rest(EcuSaid &said);
    std::size_t missing() const { return missing_; }

  private:
    std::deque<sd_event_t> waiting_;
    std::size_t missing_ = 0;
};

/// True when the edge was put on a tooth of the wheel.
bool is_placed(const sd_signals_t &signals);
/// As in hal/signals.toml, crank.edge_class: "tooth", "coasted", "spurious", "unsynced".
const char *class_name(float edge_class);
/// "valid", "degraded", "invalid".
const char *health_name(std::uint8_t health);

} // namespace sixdeg
