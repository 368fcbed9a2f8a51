// SPDX-License-Identifier: MIT
// An ecu on the bench: the firmware behind the in-process port, and the latest of what it says.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "log/port_tap.hpp"

extern "C" {
#include "sd_ecu.h"
#include "sd_inproc.h"
}

namespace sixdeg {

/// Takes events as a target's interrupts would give them. The port points into the object: neither copied nor
/// moved.
class EcuBench {
  public:
    /// `calibration` comes from calibrate(), which has checked it.
    explicit EcuBench(const sd_calibration_t &calibration);
    EcuBench(const EcuBench &) = delete;
    EcuBench &operator=(const EcuBench &) = delete;

    /// Tells `listener` of every event in and out from now on. Call it once.
    void listen(EventListener listener);
    /// Sends one event and takes in the answer. Returns true when it ended a cycle.
    bool exchange(const sd_event_t &event);
    bool exchange(std::uint16_t kind, std::uint32_t tick) { return exchange({tick, kind, 0, 0, 0}); }
    /// What a sampled sensor shows from now on; it is read every 10 ms, right before the time event.
    void show(sd_input_t input, double value) { shown_[input] = float(value); }
    /// One reading of a sampled sensor, now: for those that are read more often.
    void sample(sd_input_t input, double value, double t_s);
    /// Sends the time event that falls due every 10 ms before t_s; the first call sets where they begin.
    void tell_time_until(double t_s);
    /// Capture tick of a time, modulo 2^32.
    std::uint32_t tick_at(double t_s) const;

    const sd_signals_t &signals() const { return signals_; }
    std::uint8_t health(sd_owner_t owner) const { return health_[owner]; }
    const sd_crank_t &crank() const { return ecu_.crank; }

  private:
    void read_sensors(std::uint32_t tick);
    bool take(const sd_event_t &event);

    sd_inproc_t port_{};
    sd_port_t ecu_side_, host_side_;
    std::unique_ptr<PortTap> tap_;
    sd_ecu_t ecu_{};
    sd_signals_t signals_{};
    std::uint8_t health_[SD_OWNER_COUNT] = {};
    double tick_hz_;
    std::optional<double> next_time_s_;
    std::array<std::optional<float>, SD_INPUT_COUNT> shown_{};
};

/// True when the edge was put on a tooth of the wheel.
bool is_placed(const sd_signals_t &signals);
/// As in hal/signals.toml, crank.edge_class: "tooth", "coasted", "spurious", "unsynced".
const char *class_name(float edge_class);
/// "valid", "degraded", "invalid".
const char *health_name(std::uint8_t health);

} // namespace sixdeg
