// SPDX-License-Identifier: MIT
// The events in of a log through a fresh ecu, and what it says beside what the log says it said.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "io/log/event_log.hpp"
#include "loop/replay.hpp"

namespace sixdeg {

struct LogReplay {
    ReplayResult rows;
    std::vector<ToothRow> teeth;             ///< t_s is the time of the capture timer.
    std::vector<CycleRow> cycles;
    std::vector<FiringRow> firings;
    std::vector<WorkRow> works;
    std::vector<sd_event_t> said;            ///< Events out.
    std::vector<std::uint32_t> edge_ticks;   ///< Of the crank edges in.
    std::size_t events_in = 0, recorded_out = 0, replayed_out = 0;
    std::optional<std::size_t>
        first_difference; ///< Index among the events out; none: each row says the same to the bit, in the same order of its rate.
};

/// `calibration` is the log's own, or one of other parameters.
LogReplay replay_log(const EventLog &log, const sd_calibration_t &calibration);

/// Time of capture ticks that wrap. Ticks may step back, as a cam edge between two teeth does, by less than
/// half the timer's range.
class TickClock {
  public:
    explicit TickClock(double tick_hz) : tick_hz_(tick_hz) {}
    double seconds(std::uint32_t tick);

  private:
    double tick_hz_;
    std::optional<std::int64_t> ticks_;
};

} // namespace sixdeg
