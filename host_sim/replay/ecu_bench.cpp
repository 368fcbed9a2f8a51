// SPDX-License-Identifier: MIT
#include "replay/ecu_bench.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace sixdeg {
namespace {

constexpr double kTimeEventS = 0.01;

} // namespace

EcuBench::EcuBench(const sd_calibration_t &calibration)
    : ecu_side_(sd_inproc_ecu_side(&port_)), host_side_(sd_inproc_host_side(&port_)),
      tick_hz_(double(calibration.tick_hz)) {
    if (sd_ecu_init(&ecu_, &calibration) != SD_OK)
        throw std::logic_error("a checked calibration was refused");
}

void EcuBench::listen(EventListener listener) {
    tap_ = std::make_unique<PortTap>(ecu_side_, std::move(listener));
    ecu_side_ = tap_->port();
}

bool EcuBench::exchange(const sd_event_t &event) {
    host_side_.send(host_side_.context, &event, 1);
    sd_ecu_run(&ecu_, &ecu_side_);
    bool cycle_ended = false;
    sd_event_t answer;
    while (host_side_.receive(host_side_.context, &answer, 1) == 1) cycle_ended |= take(answer);
    return cycle_ended;
}

void EcuBench::tell_time_until(double t_s) {
    if (!next_time_s_) next_time_s_ = t_s;
    // A pause of hours needs no time event each 10 ms: one before the next edge tells as much.
    if (t_s - *next_time_s_ > 10) next_time_s_ = t_s - 10;
    for (; *next_time_s_ < t_s; *next_time_s_ += kTimeEventS) {
        read_sensors(tick_at(*next_time_s_));
        exchange(SD_EVENT_TIME, tick_at(*next_time_s_));
    }
}

void EcuBench::sample(sd_input_t input, double value, double t_s) {
    const float reading = float(value);
    sd_event_t event{tick_at(t_s), SD_EVENT_SAMPLE, std::uint16_t(input), 0, 0};
    std::memcpy(&event.value, &reading, sizeof event.value);
    exchange(event);
}

void EcuBench::read_sensors(std::uint32_t tick) {
    for (std::size_t input = 0; input < shown_.size(); ++input) {
        if (!shown_[input]) continue;
        sd_event_t event{tick, SD_EVENT_SAMPLE, std::uint16_t(input), 0, 0};
        std::memcpy(&event.value, &*shown_[input], sizeof event.value);
        exchange(event);
    }
}

std::uint32_t EcuBench::tick_at(double t_s) const {
    return std::uint32_t(std::uint64_t(std::llround(t_s * tick_hz_)));
}

bool EcuBench::take(const sd_event_t &event) {
    float value;
    std::memcpy(&value, &event.value, sizeof value);
    std::memcpy(reinterpret_cast<float *>(&signals_) + event.channel, &value, sizeof value);
    const sd_signal_info_t &info = sd_signal_infos[event.channel];
    health_[info.owner] = std::uint8_t(event.flags & 0xff);
    return info.rate == SD_RATE_CYCLE;
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
