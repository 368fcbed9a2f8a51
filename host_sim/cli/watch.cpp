// SPDX-License-Identifier: MIT
// sixdeg watch: what an ecu says, live in a terminal; with --out, truth and estimates side by side at the end.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <chrono>
#include <fmt/format.h>
#include <unistd.h>

#include "bus/bus.hpp"
#include "bus/collector.hpp"
#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "common/stop.hpp"

namespace sixdeg {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kRedraw{200}, kSilence{1000}, kTail{500};

struct Options {
    std::string transport, engine, out;
};

std::string bar(float value, float full) {
    const float share = full > 0 ? std::max(0.0f, std::min(1.0f, value / full)) : 0;
    return std::string(std::size_t(40 * share), '#');
}

std::string picture(const EcuSaid &said, std::size_t cycles, bool silent) {
    const sd_signals_t &s = said.signals();
    std::string text = fmt::format("{}\n{:8.1f} rpm  {:7.1f} deg  tooth {:3.0f}  torque {:8.1f} Nm  angle {}, torque {}, cylinders {}\n{} cycles\n",
                                   silent ? "THE ECU IS SILENT" : "", s.crank_speed_rpm, s.crank_angle_deg, s.crank_tooth, s.torque_mass_nm,
                                   health_name(said.health(SD_OWNER_CRANK)), health_name(said.health(SD_OWNER_TORQUE)),
                                   health_name(said.health(SD_OWNER_CYLINDER)), cycles);
    float largest = 0;
    for (const float torque : s.cycle_cylinder_torque_nm) largest = std::max(largest, torque);
    for (std::size_t i = 0; i < std::size(s.cycle_cylinder_torque_nm); ++i)
        text += fmt::format("cylinder {} {:9.1f} Nm {:<40}\n", i + 1, s.cycle_cylinder_torque_nm[i], bar(s.cycle_cylinder_torque_nm[i], largest));
    return text;
}

void write_tables(const Options &options, const Collector &collector) {
    TomlFile file{std::filesystem::path(options.engine)};
    const EngineFile engine = read_engine(file);
    const RunTables tables = collector.tables(engine);
    OutputFolder out(options.out);
    out.add("teeth.csv", tables.teeth_csv());
    out.add("cycles.csv", tables.cycles_csv());
    out.commit();
    fmt::print("truth lost {}, edges without an answer {}\n", collector.truth_lost(), collector.unanswered());
}

void run(const Options &options) {
    if (options.out.empty() != options.engine.empty())
        throw InputError("--out", "", "goes with --engine, which says where its cylinders fire");
    const auto bus = open_bus(options.transport, SD_ROLE_TOOL);
    const sd_port_t port = bus->port();
    stop_on_signals();
    Collector collector;
    EcuSaid said;
    std::size_t cycles = 0;
    const bool terminal = isatty(STDOUT_FILENO) != 0;
    auto heard = Clock::now(), drawn = heard;
    while (stop_signal() == 0 && !(collector.ended() && Clock::now() - heard > kTail)) {
        bus->wait(100);
        sd_truth_t truth;
        sd_event_t event;
        while (bus->next_truth(truth)) {
            if (!options.out.empty()) collector.truth(truth);
        }
        while (port.receive(port.context, &event, 1) == 1) {
            heard = Clock::now();
            said.take(event);
            cycles += event.kind == SD_EVENT_SIGNAL && event.channel == SD_SIGNAL_CYCLE_SPEED;
            if (!options.out.empty()) collector.said(event);
        }
        if (!terminal || Clock::now() - drawn < kRedraw) continue;
        drawn = Clock::now();
        fmt::print("\033[H\033[J{}", picture(said, cycles, drawn - heard > kSilence)); // from the top of an empty screen
        std::fflush(stdout);
    }
    if (!terminal) fmt::print("{}", picture(said, cycles, Clock::now() - heard > kSilence));
    if (!options.out.empty()) write_tables(options, collector);
}

} // namespace

void add_watch(CLI::App &app) {
    auto options = std::make_shared<Options>();
    CLI::App *command = app.add_subcommand("watch", "what an ecu on a bus says, live");
    command->add_option("--transport", options->transport, "can:IFACE, lcm or lcm:URL (docs/bus.md)")->required();
    command->add_option("--out", options->out, "folder for teeth.csv and cycles.csv, written when the plant's run is over");
    command->add_option("--engine", options->engine, "engine file, for --out");
    command->callback([options] { run(*options); });
}

} // namespace sixdeg
