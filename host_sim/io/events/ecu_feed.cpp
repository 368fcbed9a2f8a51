// SPDX-License-Identifier: MIT
#include "io/events/ecu_feed.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sixdeg {
namespace {

constexpr double kTimeEventS = 0.01;

bool is_signal(const sd_event_t &event, sd_rate_t rate) {
    return event.kind == SD_EVENT_SIGNAL && event.channel < SD_SIGNAL_COUNT && sd_signal_infos[event.channel].rate == rate;
}

sd_event_t reading(std::size_t input, float value, std::uint32_t tick) {
    sd_event_t event{tick, SD_EVENT_SAMPLE, std::uint16_t(input), 0, 0};
    std::memcpy(&event.value, &value, sizeof event.value);
    return event;
}

} // namespace

bool EcuSaid::take(const sd_event_t &event) {
    if (event.kind != SD_EVENT_SIGNAL || event.channel >= SD_SIGNAL_COUNT) return false;
    float value;
    std::memcpy(&value, &event.value, sizeof value);
    std::memcpy(reinterpret_cast<float *>(&signals_) + event.channel, &value, sizeof value);
    const sd_signal_info_t &info = sd_signal_infos[event.channel];
    health_[info.owner] = std::uint8_t(event.flags & 0xff);
    firings_ += event.channel == SD_SIGNAL_FIRING_CYLINDER;
    works_ += event.channel == SD_SIGNAL_WORK_CYCLE;
    if (event.channel == SD_SIGNAL_CRANK_EDGE_CLASS) {
        sync_losses_ += synced_ && value == SD_EDGE_UNSYNCED;
        synced_ = is_placed(signals_) || (synced_ && value == SD_EDGE_SPURIOUS);
    }
    return info.rate == SD_RATE_CYCLE && completes_cycle(event);
}

/// A channel of another tick, or said twice, begins a new row: the one before was torn.
bool EcuSaid::completes_cycle(const sd_event_t &event) {
    if (event.tick != gathering_tick_ || gathered_[event.channel]) gathered_.reset();
    gathering_tick_ = event.tick;
    gathered_.set(event.channel);
    if (gathered_.count() != sd_rate_infos[SD_RATE_CYCLE].count) return false;
    gathered_.reset();
    cycle_tick_ = event.tick;
    return true;
}

void EcuSaid::distrust() { std::fill(std::begin(health_), std::end(health_), std::uint8_t(SD_INVALID)); }

void EcuFeed::tell_time_until(double t_s) {
    if (!next_time_s_) next_time_s_ = t_s;
    // A pause of hours needs no time event each 10 ms: one before the next edge tells as much.
    if (t_s - *next_time_s_ > 10) next_time_s_ = t_s - 10;
    for (; *next_time_s_ < t_s; *next_time_s_ += kTimeEventS) tell_time(*next_time_s_);
}

void EcuFeed::finish(double t_s) {
    tell_time_until(t_s);
    tell_time(t_s);
}

void EcuFeed::read_sensors(std::uint32_t tick) {
    for (std::size_t input = 0; input < shown_.size(); ++input) {
        if (shown_[input]) send(reading(input, *shown_[input], tick));
    }
}

void EcuFeed::sample(sd_input_t input, double value, double t_s) { send(reading(input, float(value), tick_at(t_s))); }

void EcuFeed::tell_time(double t_s) {
    ++clock_events_;
    read_sensors(tick_at(t_s));
    send({tick_at(t_s), SD_EVENT_TIME, 0, 0, 0});
    if (!restart_at_s_ || t_s < *restart_at_s_) return;
    restart_at_s_.reset();
    restart();
}

std::uint32_t EcuFeed::tick_at(double t_s) const {
    return std::uint32_t(std::uint64_t(std::llround(t_s * tick_hz_)));
}

bool Answers::take(std::uint32_t tick, EcuSaid &said) {
    const std::ptrdiff_t edge_channels = sd_rate_infos[SD_RATE_EDGE].count;
    const auto its_own = [tick](const sd_event_t &e) { return is_signal(e, SD_RATE_EDGE) && e.tick == tick; };
    const auto first = std::find_if(waiting_.begin(), waiting_.end(), its_own);
    const auto end = first + std::min(edge_channels, waiting_.end() - first);
    if (std::count_if(first, end, its_own) != edge_channels) {
        ++missing_;
        said.distrust();
        return false;
    }
    bool cycle_ended = false;
    std::for_each(waiting_.begin(), end, [&](const sd_event_t &e) { cycle_ended |= said.take(e); });
    waiting_.erase(waiting_.begin(), end);
    return cycle_ended;
}

void Answers::take_rest(EcuSaid &said) {
    for (const sd_event_t &event : waiting_) said.take(event);
    waiting_.clear();
}

bool is_placed(const sd_signals_t &signals) {
    return signals.crank_edge_class == SD_EDGE_TOOTH || signals.crank_edge_class == SD_EDGE_COASTED;
}

const char *class_name(float edge_class) {
    static const char *const names[] = {"tooth", "coasted", "spurious", "unsynced"};
    return names[int(edge_class)];
}

const char *health_name(std::uint8_t health) {
    static const char *const names[] = {"valid", "degraded", "invalid"};
    return names[health];
}

} // namespace sixdeg
