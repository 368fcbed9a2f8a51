// SPDX-License-Identifier: MIT
#include "loop/ecu_process.hpp"

#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <random>
#include <stdexcept>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "io/log/port_tap.hpp"
#include "io/page/page_bytes.hpp"

namespace sixdeg {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
constexpr milliseconds kProbe{100}, kSilence{1000};

void say(const std::string &what) { fmt::print(stderr, "sixdeg ecu: {}\n", what); }

/// Two that start at once both hear of each other; the lower id stays.
void claim_the_bus(Bus &bus, const std::string &transport) {
    const std::uint32_t id = std::random_device()() % (SD_CLAIM_WHO - 1) + 1;
    const auto until = Clock::now() + kProbe;
    bus.claim({id, SD_SIGNALS_SIGNATURE});
    while (Clock::now() < until) {
        const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
        bus.wait(int(left.count()));
        sd_event_t event; // whatever a plant says meanwhile is before our time
        const sd_port_t port = bus.port();
        while (port.receive(port.context, &event, 1) == 1) {}
        const auto other = bus.heard_claim();
        if (!other || other->id == SD_CLAIM_WHO || other->id == id) continue;
        if (other->id < id) throw InputError(transport, "", "another ecu is on this bus; stop it first, or use another bus");
        bus.claim({id, SD_SIGNALS_SIGNATURE});
    }
    bus.claim({SD_CLAIM_RUNNING, SD_SIGNALS_SIGNATURE});
}

/// Says when the plant falls silent, is back, and is another one.
class PlantWatch {
  public:
    explicit PlantWatch(const Bus &bus) : bus_(bus) {}
    void heard() {
        last_ = Clock::now();
        if (silent_) say("the plant is back");
        silent_ = false;
        known_ = true;
    }
    void look() {
        if (bus_.peer_starts() != starts_) say("the plant has been started anew");
        starts_ = bus_.peer_starts();
        if (!known_ || silent_ || Clock::now() - last_ < kSilence) return;
        silent_ = true;
        say("no clock event for a second: the plant is silent");
    }

  private:
    const Bus &bus_;
    std::uint32_t starts_ = 0;
    Clock::time_point last_{};
    bool known_ = false, silent_ = false;
};

} // namespace

void run_ecu(Bus &bus, const std::string &transport, const sd_calibration_t &calibration, const EventListener &listener) {
    const auto ecu = std::make_unique<sd_ecu_t>();
    const StoredPage page(calibration);
    if (sd_ecu_init(ecu.get(), page.view()) != SD_OK) throw std::logic_error("a checked calibration was refused");
    claim_the_bus(bus, transport);
    say("running on " + transport);
    PlantWatch plant(bus);
    PortTap tap(bus.port(), [&](bool out, const sd_event_t &event) {
        if (!out && event.kind == SD_EVENT_TIME) plant.heard();
        if (listener) listener(out, event);
    });
    const sd_port_t port = tap.port();
    while (stop_signal() == 0) {
        bus.wait(100);
        sd_ecu_run(ecu.get(), page.view(), &port);
        const auto claim = bus.heard_claim();
        if (claim && claim->id != SD_CLAIM_RUNNING) bus.claim({SD_CLAIM_RUNNING, SD_SIGNALS_SIGNATURE});
        plant.look();
    }
    say(fmt::format("stopped; {}; events ignored {}, signals without room {}", describe(bus.counts()), ecu->unknown_events,
                    ecu->say.unsent));
}

} // namespace sixdeg
