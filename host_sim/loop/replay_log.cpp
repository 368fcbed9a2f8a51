// SPDX-License-Identifier: MIT
#include "loop/replay_log.hpp"

#include <algorithm>
#include <tuple>

namespace sixdeg {
namespace {

bool same(const sd_event_t &a, const sd_event_t &b) {
    return std::tie(a.tick, a.kind, a.channel, a.value, a.flags) ==
           std::tie(b.tick, b.kind, b.channel, b.value, b.flags);
}

} // namespace

double TickClock::seconds(std::uint32_t tick) {
    if (!ticks_) ticks_ = tick;
    *ticks_ += std::int32_t(tick - std::uint32_t(*ticks_));
    return double(*ticks_) / tick_hz_;
}

LogReplay replay_log(const EventLog &log, const sd_calibration_t &calibration) {
    LogReplay result;
    std::vector<sd_event_t> recorded, &replayed = result.said;
    const auto bench = std::make_unique<EcuBench>(calibration);
    bench->listen([&](bool out, const sd_event_t &event) {
        if (out) replayed.push_back(event);
    });
    ReplayRows rows;
    TickClock clock(double(calibration.tick_hz));
    for (sd_event_t event : log.events) {
        if (event.kind & kLoggedOut) {
            event.kind = std::uint16_t(event.kind & ~kLoggedOut);
            recorded.push_back(event);
            continue;
        }
        ++result.events_in;
        const double t_s = clock.seconds(event.tick);
        const bool cycle_ended = bench->exchange(event);
        if (event.kind != SD_EVENT_CRANK_EDGE) continue;
        rows.edge(t_s, cycle_ended, *bench);
        result.edge_ticks.push_back(event.tick);
    }
    result.rows = rows.finish(*bench);
    result.recorded_out = recorded.size();
    result.replayed_out = replayed.size();
    const auto differs =
        std::mismatch(recorded.begin(), recorded.end(), replayed.begin(), replayed.end(), same);
    if (differs.first != recorded.end() || differs.second != replayed.end())
        result.first_difference = std::size_t(differs.first - recorded.begin());
    return result;
}

} // namespace sixdeg
