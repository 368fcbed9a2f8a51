// SPDX-License-Identifier: MIT
#include "loop/replay_log.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace sixdeg {
namespace {

bool same(const sd_event_t &a, const sd_event_t &b) {
    return std::tie(a.tick, a.kind, a.channel, a.value, a.flags) ==
           std::tie(b.tick, b.kind, b.channel, b.value, b.flags);
}

/// Signals of one rate keep their order, and so do all other events of a kind. Between them there is none: a bus sends a row when it
/// is complete, and one process as soon as its parts are said.
struct Stream {
    std::vector<std::size_t> index; ///< Among the events out of the log.
    std::vector<sd_event_t> recorded, replayed;
};

std::pair<int, int> stream_of(const sd_event_t &event) {
    const bool signal = event.kind == SD_EVENT_SIGNAL && event.channel < SD_SIGNAL_COUNT;
    return {event.kind, signal ? sd_signal_infos[event.channel].rate : -1};
}

/// Events that a replay may say at its end and a bus does not: a row that was still incomplete.
std::size_t unfinished(std::pair<int, int> stream, std::size_t said) {
    return stream.second < 0 ? 0 : said % sd_rate_infos[stream.second].count;
}

std::optional<std::size_t> first_difference(const std::vector<sd_event_t> &recorded, const std::vector<sd_event_t> &replayed) {
    std::map<std::pair<int, int>, Stream> streams;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
        Stream &stream = streams[stream_of(recorded[i])];
        stream.index.push_back(i), stream.recorded.push_back(recorded[i]);
    }
    for (const sd_event_t &event : replayed) streams[stream_of(event)].replayed.push_back(event);
    std::optional<std::size_t> first;
    for (auto &[key, stream] : streams) {
        const auto &[index, was, is] = stream;
        const std::size_t at = std::size_t(std::mismatch(was.begin(), was.end(), is.begin(), is.end(), same).first - was.begin());
        const std::size_t extra = is.size() - std::min(is.size(), was.size());
        if (at == was.size() && (extra == 0 || extra == unfinished(key, is.size()))) continue;
        const std::size_t here = at < index.size() ? index[at] : recorded.size();
        first = std::min(first.value_or(here), here);
    }
    return first;
}

/// Rows of a log are kept: beside truth they are looked at again.
struct Keep : ReplaySink {
    explicit Keep(LogReplay &into) : log(into) {}
    void tooth(std::size_t, const ToothRow &row) override { log.teeth.push_back(row); }
    void cycle(std::size_t, const CycleRow &row) override { log.cycles.push_back(row); }
    void firing(std::size_t, const FiringRow &row) override { log.firings.push_back(row); }
    void work(std::size_t, const WorkRow &row) override { log.works.push_back(row); }
    LogReplay &log;
};

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
    Keep kept(result);
    ReplayRows rows(kept);
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
        if (event.kind == SD_EVENT_CAM_EDGE) rows.cam_edge();
        if (event.kind != SD_EVENT_CRANK_EDGE) continue;
        rows.edge(t_s, cycle_ended, bench->said());
        result.edge_ticks.push_back(event.tick);
    }
    result.rows = rows.finish(bench->crank());
    result.rows.evidence = bench->evidence();
    result.recorded_out = recorded.size();
    result.replayed_out = replayed.size();
    result.first_difference = first_difference(recorded, replayed);
    return result;
}

} // namespace sixdeg
