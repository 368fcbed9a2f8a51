// SPDX-License-Identifier: MIT
// sixdeg watch: what an ecu says, live in a terminal; with --out, truth and estimates side by side at the end.
#include <chrono>
#include <fmt/format.h>
#include <unistd.h>

#include "io/bus/bus.hpp"
#include "io/bus/collector.hpp"
#include "io/bus/live_view.hpp"
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
    fmt::print(stderr, "sixdeg watch: listening on {}\n", options.transport);
    Collector collector;
    LiveView view;
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
            view.take(event);
            if (!options.out.empty()) collector.said(event);
        }
        if (!terminal || Clock::now() - drawn < kRedraw) continue;
        drawn = Clock::now();
        fmt::print("\033[H\033[J{}", view.text(drawn - heard > kSilence)); // from the top of an empty screen
        std::fflush(stdout);
    }
    if (!terminal) fmt::print("{}", view.text(Clock::now() - heard > kSilence));
    if (!options.out.empty()) write_tables(options, collector);
}

} // namespace

void add_watch(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("watch", "what an ecu on a bus says, live");
    command.task("Over a bus", "watch --transport lcm");
    command.option("--transport", options->transport, "can:IFACE, lcm or lcm:URL (docs/reference/bus.md)").required();
    command.output_folder(options->out, "folder for teeth.csv and cycles.csv, written when the plant's run is over");
    command.option("--engine", options->engine, "engine file, for --out");
    command.runs_without_progress([options] { run(*options); });
}

} // namespace sixdeg
