// SPDX-License-Identifier: MIT
// A port that tells a listener of every event it moves.
#pragma once
#include <cstdint>
#include <functional>

extern "C" {
#include "hal.h"
}

namespace sixdeg {

/// `out`: from the ecu. Events that the port had no room for are not told of.
using EventListener = std::function<void(bool out, const sd_event_t &event)>;

/// Stands between the ecu and `inner`. Its port points into it, so it is neither copied nor moved.
class PortTap {
  public:
    PortTap(sd_port_t inner, EventListener listener) : inner_(inner), listener_(std::move(listener)) {}
    PortTap(const PortTap &) = delete;
    PortTap &operator=(const PortTap &) = delete;

    sd_port_t port() { return {this, receive, send}; }

  private:
    static std::uint32_t receive(void *context, sd_event_t *events, std::uint32_t room) {
        auto &self = *static_cast<PortTap *>(context);
        return self.tell(false, events, self.inner_.receive(self.inner_.context, events, room));
    }
    static std::uint32_t send(void *context, const sd_event_t *events, std::uint32_t count) {
        auto &self = *static_cast<PortTap *>(context);
        return self.tell(true, events, self.inner_.send(self.inner_.context, events, count));
    }
    std::uint32_t tell(bool out, const sd_event_t *events, std::uint32_t count) const {
        for (std::uint32_t i = 0; i < count; ++i) listener_(out, events[i]);
        return count;
    }

    sd_port_t inner_;
    EventListener listener_;
};

} // namespace sixdeg
