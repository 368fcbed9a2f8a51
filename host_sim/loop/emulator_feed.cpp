// SPDX-License-Identifier: MIT
#include "loop/emulator_feed.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <unistd.h>

#include "common/error.hpp"
#include "common/files.hpp"
#include "common/stop.hpp"
#include "io/page/page_bytes.hpp"

namespace sixdeg {
namespace {

constexpr int kShift = 10;
/// A tick of the core's timer is 40 ns.
double instructions(std::uint32_t ticks) { return double(ticks) * 40 / (1 << kShift); }

std::filesystem::path page_file() {
    static int files = 0;
    return std::filesystem::temp_directory_path() / fmt::format("sixdeg_{}_{}.page", getpid(), ++files);
}

} // namespace

EmulatorFeed::EmulatorFeed(const EmulatedCore &core, const sd_calibration_t &calibration, EventListener listener)
    : EcuFeed(double(calibration.tick_hz)), image_(image_of(core)), page_(page_file()), listener_(std::move(listener)) {
    figures_.core = &core;
    const auto bytes = page_bytes(calibration);
    write_file(page_, std::string(bytes.begin(), bytes.end()));
    try {
        begin();
    } catch (...) {
        std::filesystem::remove(page_);
        throw;
    }
}

EmulatorFeed::~EmulatorFeed() {
    std::error_code ignored;
    std::filesystem::remove(page_, ignored);
}

void EmulatorFeed::begin() {
    emulator_.reset();
    emulator_ = std::make_unique<Emulator>(*figures_.core, EmulatorStart{image_, page_, {}, kShift});
    figures_.hello = emulator_->hello();
}

void EmulatorFeed::restart() {
    exchange();
    ++figures_.restarts;
    begin();
}

void EmulatorFeed::send(const sd_event_t &event) {
    waiting_.push_back(event);
    if (event.kind == SD_EVENT_TIME || waiting_.size() == SD_LINK_EVENTS) exchange();
}

void EmulatorFeed::take(const EmulatedAnswer &answer) {
    if (listener_) listener_(false, answer.frame.in);
    for (const sd_event_t &event : answer.said) {
        if (listener_) listener_(true, event);
        hear(event);
    }
    if (answer.frame.in.kind == SD_EVENT_CRANK_EDGE) figures_.tooth.add(instructions(answer.frame.ticks));
    if (answer.frame.in.kind == SD_EVENT_TIME) figures_.clock.add(instructions(answer.frame.ticks));
}

void EmulatorFeed::exchange() {
    if (waiting_.empty()) return;
    std::vector<EmulatedAnswer> answers;
    const bool alive = emulator_->exchange(waiting_, answers);
    waiting_.clear();
    for (const EmulatedAnswer &answer : answers) take(answer);
    if (alive) return;
    fmt::print(stderr, "sixdeg run: the emulated controller has died and is started anew\n");
    ++figures_.died, ++figures_.restarts;
    if (figures_.died > 100) throw InputError("qemu-system-arm", "", "the controller has died 100 times");
    begin();
}

void EmulatorFeed::finish_controller() {
    exchange();
    emulator_->finish(figures_.end);
}

RunResult run_on_emulator(const std::string &transport, const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                          const EventListener &listener, std::optional<double> restart_s, EmulatorFigures &figures) {
    EmulatorFeed feed(emulated_core(transport), calibration, listener);
    if (restart_s) feed.restart_at(*restart_s);
    const RunResult result = run_scenario(scenario, calibration, feed, tables);
    feed.finish_controller();
    figures = feed.figures();
    return result;
}

nlohmann::ordered_json emulator_json(const EmulatorFigures &f, std::size_t unanswered) {
    const auto cost = [](const HandlingCost &c) {
        return nlohmann::ordered_json{{"count", c.count}, {"average", std::llround(c.average())}, {"worst", std::llround(c.worst)}};
    };
    return {{"core", f.core->preset},
            {"name", f.core->name},
            {"restarts", f.restarts},
            {"died", f.died},
            {"edges_unanswered", unanswered},
            {"tooth_instructions", cost(f.tooth)},
            {"clock_instructions", cost(f.clock)},
            {"ecu_bytes", f.hello.ecu_bytes},
            {"stack_bytes", f.end.stack_bytes},
            {"overruns", f.end.overruns},
            {"lost_edges", f.end.lost_edges + f.end.lost_others}};
}

void print_emulator(const EmulatorFigures &f, std::size_t unanswered) {
    const auto row = [](const char *name, const std::string &value) { fmt::print("{:<34}{}\n", name, value); };
    row("controller", fmt::format("emulated {}", f.core->name));
    row("  instructions a tooth", fmt::format("{:.0f} on average, {:.0f} at most", f.tooth.average(), f.tooth.worst));
    row("  of a clock event", fmt::format("{:.0f} on average, {:.0f} at most", f.clock.average(), f.clock.worst));
    row("  bytes: ecu, stack", fmt::format("{}, {}", f.hello.ecu_bytes, f.end.stack_bytes));
    row("  started anew, after it had died", fmt::format("{}, {}", f.restarts, f.died));
    row("  edges without an answer", std::to_string(unanswered));
}

} // namespace sixdeg
