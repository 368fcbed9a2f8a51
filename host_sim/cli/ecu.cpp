// SPDX-License-Identifier: MIT
// sixdeg ecu: the firmware as a process of its own on a bus.
#include <optional>

#include "loop/ecu_process.hpp"
#include "design/calibration.hpp"
#include "cli/commands.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "common/stop.hpp"
#include "io/log/event_log.hpp"

namespace sixdeg {
namespace {

struct Options {
    std::string file, transport, tune, number, record;
    std::vector<std::string> set;
};

/// A page as it is, or the page of an engine file and a tune. Adds to `about` what an event log says of it.
sd_calibration_t read_calibration(const Options &options, nlohmann::ordered_json &about) {
    const std::string content = read_file(options.file);
    about["files"][options.file] = sha256(content);
    if (content.rfind("SDC3", 0) == 0) {
        const auto page = read_page(content);
        const auto ecu = std::make_unique<sd_ecu_t>();
        if (page && sd_ecu_init(ecu.get(), page.get()) == SD_OK) return *page;
        throw InputError(options.file, "", "the calibration page is damaged, or of another table of signals");
    }
    TomlFile engine_toml{std::filesystem::path(options.file)};
    const EngineFile engine = read_engine(engine_toml);
    engine_toml.finish();
    about["engine"] = {{"name", engine.name}, {"guessed", engine.guessed}};
    about["engine_file"] = content;
    TomlFile tune = open_tune(options.tune, options.set, options.number);
    const sd_parameters_t parameters = read_tune(tune);
    return calibrate(engine, parameters, tune.name());
}

void run(const Options &options) {
    nlohmann::ordered_json about = {{"sixdeg", SD_VERSION}, {"command", "ecu"}, {"set", options.set}};
    const sd_calibration_t calibration = read_calibration(options, about);
    const auto bus = open_bus(options.transport, SD_ROLE_ECU);
    std::optional<LogWriter> log;
    if (!options.record.empty()) log.emplace(options.record, about.dump(), calibration);
    EventListener listener;
    if (log) listener = [&](bool out, const sd_event_t &event) { log->add(out, event); };
    stop_on_signals();
    run_ecu(*bus, options.transport, calibration, listener);
    if (log) log->finish();
}

} // namespace

void add_ecu(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("ecu", "the firmware as a process of its own on a bus");
    command.task("Over a bus", "ecu ENGINE.toml --transport lcm");
    command.option("ENGINE", options->file, "engine file, or a calibration page").required();
    command.option("--transport", options->transport, "can:IFACE, lcm or lcm:URL (docs/reference/bus.md)").required();
    command.option("--tune", options->tune, "tune file");
    command.settings(options->set, "key=value, over the tune file");
    command.number(options->number);
    command.option("--record", options->record, "event log of all that goes in and out (docs/reference/log.md)");
    command.runs_without_progress([options] { run(*options); });
}

} // namespace sixdeg
