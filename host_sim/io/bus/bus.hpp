// SPDX-License-Identifier: MIT
// One end of a bus, CAN or LCM: `can:IFACE`, `lcm`, `lcm:URL`.
#pragma once
#include <memory>
#include <optional>
#include <string>

extern "C" {
#include "sd_role.h"
#include "sd_row.h"
}

namespace sixdeg {

class Bus {
  public:
    virtual ~Bus() = default;
    virtual sd_port_t port() = 0;
    /// Waits until something comes, at most so long; true when events may be there.
    virtual bool wait(int milliseconds) = 0;
    virtual void claim(sd_claim_t claim) = 0;
    /// The last claim heard since asked before.
    virtual std::optional<sd_claim_t> heard_claim() = 0;
    virtual void send_truth(const sd_truth_t &truth) = 0;
    /// Truth heard, one by one; for a tool.
    virtual bool next_truth(sd_truth_t &truth) = 0;
    /// Times the other side, ecu or plant, has started anew.
    virtual std::uint32_t peer_starts() const = 0;
    virtual const sd_port_counts_t &counts() const = 0;
};

/// Throws InputError when there is no such bus.
std::unique_ptr<Bus> open_bus(const std::string &transport, sd_role_t role);

/// "sent 12, received 34, unsent 0, foreign 0, malformed 0, gaps 0, stale 0"
std::string describe(const sd_port_counts_t &counts);

} // namespace sixdeg
