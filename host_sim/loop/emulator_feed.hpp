// SPDX-License-Identifier: MIT
// The ecu on an emulated controller.
//
// Lock-step: events are kept until the clock event that closes a batch; the controller then handles all of them, however long that
// takes, and its time stands still in between. So a run is the same to the bit as one whose ecu is in this process.
//
// A controller that dies is started anew: the events it was handling are lost, and those that follow go to an ecu that has just been
// initialised, as in-process after EcuFeed::restart().
#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/emulator/emulator.hpp"
#include "io/events/ecu_feed.hpp"
#include "io/log/port_tap.hpp"
#include "loop/bench_run.hpp"

namespace sixdeg {

/// Instructions of what the ecu did with events of one kind.
struct HandlingCost {
    std::size_t count = 0;
    double sum = 0, worst = 0;
    double average() const { return count == 0 ? 0 : sum / double(count); }
    void add(double instructions) { ++count, sum += instructions, worst = std::max(worst, instructions); }
};

struct EmulatorFigures {
    const EmulatedCore *core = nullptr;
    std::size_t restarts = 0;   ///< Times the controller was started anew, wanted or not.
    std::size_t died = 0;       ///< Of those, because it had died.
    HandlingCost tooth, clock;  ///< Crank edges; clock events.
    sd_link_hello_t hello{};
    sd_link_end_t end{};        ///< Of its last life.
};

class EmulatorFeed : public EcuFeed {
  public:
    /// Starts the controller. Throws InputError.
    EmulatorFeed(const EmulatedCore &core, const sd_calibration_t &calibration, EventListener listener = {});
    ~EmulatorFeed() override;

    void send(const sd_event_t &event) override;
    void restart() override;
    /// Ends the controller in good order.
    void finish_controller();
    const EmulatorFigures &figures() const { return figures_; }
    /// The emulator's process, so that a test can kill it.
    pid_t process() const { return emulator_->process(); }

  private:
    void begin();
    void exchange();
    void take(const EmulatedAnswer &answer);

    std::filesystem::path image_, page_;
    EventListener listener_;
    std::unique_ptr<Emulator> emulator_;
    std::vector<sd_event_t> waiting_;
    EmulatorFigures figures_;
};

/// Runs a scenario with the ecu on an emulated controller, which starts anew at `restart_s` where that is set.
RunResult run_on_emulator(const std::string &transport, const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                          const EventListener &listener, std::optional<double> restart_s, EmulatorFigures &figures);

/// Of summary.json.
nlohmann::ordered_json emulator_json(const EmulatorFigures &figures, std::size_t unanswered);
void print_emulator(const EmulatorFigures &figures, std::size_t unanswered);

} // namespace sixdeg
