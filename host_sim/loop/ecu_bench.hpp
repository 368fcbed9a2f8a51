// SPDX-License-Identifier: MIT
// An ecu on the bench: the firmware behind the in-process port, and the latest of what it says.
#pragma once
#include <memory>

#include "io/log/port_tap.hpp"
#include "io/page/page_bytes.hpp"
#include "io/events/ecu_feed.hpp"
#include "loop/evidence.hpp"

extern "C" {
#include "sd_ecu.h"
#include "sd_inproc.h"
}

namespace sixdeg {

/// Takes events as a target's interrupts would give them. The port points into the object: neither copied nor
/// moved.
class EcuBench : public EcuFeed {
  public:
    /// `calibration` comes from calibrate(), which has checked it.
    explicit EcuBench(const sd_calibration_t &calibration);
    EcuBench(const EcuBench &) = delete;
    EcuBench &operator=(const EcuBench &) = delete;

    /// Tells `listener` of every event in and out from now on. Call it once.
    void listen(EventListener listener);
    void send(const sd_event_t &event) override { exchange(event); }
    void restart() override;
    /// Sends one event and takes in the answer. Returns true when it ended a cycle.
    bool exchange(const sd_event_t &event);
    bool exchange(std::uint16_t kind, std::uint32_t tick) { return exchange({tick, kind, 0, 0, 0}); }

    const EcuSaid &said() const { return said_; }
    const sd_signals_t &signals() const { return said_.signals(); }
    std::uint8_t health(sd_owner_t owner) const { return said_.health(owner); }
    const sd_crank_t &crank() const { return ecu_.crank; }
    const sd_ecu_t &ecu() const { return ecu_; }
    const sd_pattern_t &pattern() const { return ecu_.firings.pattern; }
    /// What was learned so far, and learning that goes on from what was kept. False: it is of another wheel or lambda sensor.
    sd_kept_t learned() const {
        sd_kept_t kept;
        sd_ecu_keep(&ecu_, page_.view(), &kept);
        return kept;
    }
    /// What was seen so far that says how well the page fits the engine.
    Evidence evidence() const;
    bool resume(const sd_kept_t &learned) { return sd_ecu_resume(&ecu_, page_.view(), &learned) == SD_OK; }

  private:
    StoredPage page_;
    sd_inproc_t port_{};
    sd_port_t ecu_side_, host_side_;
    std::unique_ptr<PortTap> tap_;
    sd_ecu_t ecu_{};
    EcuSaid said_;
    FuelCutReading fuel_cut_;
};

} // namespace sixdeg
