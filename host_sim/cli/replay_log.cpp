// SPDX-License-Identifier: MIT
// sixdeg replay of an event log: what went into the ecu once goes into a fresh one.
#include "replay/replay_log.hpp"

#include <fmt/format.h>

#include "calibration/calibration.hpp"
#include "cli/replay_command.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "common/files.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

void refuse_options_of_recordings(const ReplayOptions &options) {
    const auto refuse = [&](bool given, const char *option) {
        if (given)
            throw InputError(
                options.file, option,
                "an event log holds its own calibration page; allowed are --tune, --set, --number");
    };
    refuse(!options.engine.empty(), "--engine");
    refuse(!options.wheel.empty(), "--wheel");
    refuse(!options.edge.empty(), "--edge");
    refuse(options.column != 0, "--column");
}

bool is_changed(const ReplayOptions &options) {
    return !options.tune.empty() || !options.set.empty() || !options.number.empty();
}

Json about(const EventLog &log, const std::string &file) {
    Json json = Json::parse(log.about, nullptr, false);
    if (json.is_discarded()) throw InputError(file, "", "has a description that is not JSON");
    return json;
}

Json outputs_json(const LogReplay &replayed) {
    Json first;
    if (replayed.first_difference) first = *replayed.first_difference;
    return {{"recorded", replayed.recorded_out},
            {"replayed", replayed.replayed_out},
            {"identical", !replayed.first_difference},
            {"first_difference", first}};
}

} // namespace

void replay_event_log(const ReplayOptions &options) {
    refuse_options_of_recordings(options);
    const EventLog log = read_log(options.file);
    TomlFile tune = open_tune(options.tune, options.set, options.number);
    const sd_parameters_t parameters = read_tune(tune, &log.calibration.parameters);
    // An unchanged page has passed every check already, or the log would not be there.
    const sd_calibration_t page =
        is_changed(options) ? retune(log.calibration, parameters, tune.name()) : log.calibration;

    Json summary = {{"log", about(log, options.file)}};
    const LogReplay replayed = replay_log(log, page);
    summary.update(figures_json(replayed.rows));
    summary["decoder"] = decoder_json(replayed.rows);
    summary["events_in"] = replayed.events_in;
    summary["outputs"] = outputs_json(replayed);
    summary["set"] = options.set;
    summary["parameters"] = parameters_json(parameters);
    summary["files"][options.file] = sha256(read_file(options.file));
    if (!options.tune.empty()) summary["files"][options.tune] = sha256(tune.content());

    const std::vector<int> firing_order(page.firing_order, page.firing_order + page.cylinders);
    write_replay(options, summary, replayed.rows, firing_order);
    fmt::print("{} events in, {} out\n", replayed.events_in, replayed.replayed_out);
    print_counts(replayed.rows);
    if (replayed.first_difference) {
        fmt::print("events out differ from the recorded {}, first at number {}\n", replayed.recorded_out,
                   *replayed.first_difference);
    } else {
        fmt::print("events out are the recorded ones, bit for bit\n");
    }
}

} // namespace sixdeg
