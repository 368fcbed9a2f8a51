// SPDX-License-Identifier: MIT
// sixdeg replay of an event log: what went into the ecu once goes into a fresh one.
#include "loop/replay_log.hpp"

#include <fmt/format.h>

#include "cli/contradictions.hpp"
#include "cli/replay_command.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "design/calibration.hpp"
#include "loop/truth_folder.hpp"

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
    refuse(!options.column.empty(), "--column");
    refuse(!options.threshold.empty(), "--threshold");
    refuse(!options.time_unit.empty(), "--time-unit");
    refuse(!(options.cam + options.parity).empty(), "--cam, --parity");
    refuse(!(options.intake + options.fuel + options.lambda + options.load).empty(), "--intake, --fuel, --lambda, --load");
    refuse(!(options.learned + options.learn).empty(), "--learned, --learn");
}

bool is_changed(const ReplayOptions &options) {
    return !options.tune.empty() || !options.set.empty() || !options.number.empty();
}

Json about(const EventLog &log, const std::string &file) {
    Json json = Json::parse(log.about, nullptr, false);
    if (!json.is_object()) throw InputError(file, "", "has a description that is no JSON object");
    return json;
}

/// The engine that the log holds.
EngineFile engine_of(const std::string &file, const Json &about, const char *what_for) {
    const auto engine_file = about.find("engine_file");
    if (engine_file == about.end() || !engine_file->is_string())
        throw InputError(file, "", fmt::format("holds no engine file, so {}", what_for));
    TomlFile engine(file + ": engine_file", engine_file->get<std::string>());
    return read_engine(engine);
}

/// The page with the parameters asked for. Parts of it follow from engine and parameters together, so it is
/// made anew.
sd_calibration_t changed_page(const std::string &file, const Json &about, const sd_parameters_t &parameters,
                              const std::string &tune_name) {
    return calibrate(engine_of(file, about, "its parameters cannot be changed"), parameters, tune_name);
}

/// Of an engine file that does not fit what the replayed ecu saw; none where the log holds no engine file.
std::vector<std::string> warnings_of(const std::string &file, const Json &about, const sd_parameters_t &tune, const LogReplay &replayed) {
    if (!about.contains("engine_file")) return {};
    return contradictions(engine_of(file, about, "it cannot be judged"), tune, replayed.rows.evidence);
}

/// The run's tables again, truth beside what the replay says.
void write_beside_truth(const ReplayOptions &options, const Json &about, const LogReplay &replayed, const std::string &summary) {
    const RunTables tables = beside_truth(options.truth, engine_of(options.file, about, "truth has nothing to stand beside"), replayed);
    OutputFolder out(options.out);
    out.add("summary.json", summary);
    out.add("teeth.csv", tables.teeth_csv());
    out.add("cycles.csv", tables.cycles_csv());
    out.commit();
}

void write_tables(const ReplayOptions &options, const sd_calibration_t &page, const LogReplay &replayed, const Json &summary) {
    ReplayOutput out(options, {{page.firing_order, page.firing_order + page.cylinders}, double(page.parameters.afr_stoichiometric), true});
    std::size_t i = 0;
    // A cycle takes its cylinders from the firings before it, so rows go in order of time.
    std::size_t firing = 0, cycle = 0;
    for (std::size_t work = 0; work < replayed.works.size(); ++work) out.sink().work(work, replayed.works[work]);
    for (const ToothRow &row : replayed.teeth) {
        out.sink().tooth(i++, row);
        for (; firing < replayed.firings.size() && replayed.firings[firing].t_s <= row.t_s; ++firing)
            out.sink().firing(firing, replayed.firings[firing]);
        for (; cycle < replayed.cycles.size() && replayed.cycles[cycle].t_s <= row.t_s; ++cycle)
            out.sink().cycle(cycle, replayed.cycles[cycle]);
    }
    out.commit(summary);
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
    Json description = about(log, options.file);
    const sd_calibration_t page = is_changed(options)
                                      ? changed_page(options.file, description, parameters, tune.name())
                                      : log.calibration;
    const LogReplay replayed = replay_log(log, page);
    const Json with_engine = description;
    description.erase("engine_file"); // long, and `files` has its checksum
    Json summary = {{"log", description}};
    summary.update(figures_json(replayed.rows));
    summary["decoder"] = decoder_json(replayed.rows);
    summary["events_in"] = replayed.events_in;
    summary["outputs"] = outputs_json(replayed);
    const std::vector<std::string> warnings = warnings_of(options.file, with_engine, page.parameters, replayed);
    summary["warnings"] = warnings;
    summary["set"] = options.set;
    summary["parameters"] = parameters_json(page.parameters);
    summary["files"][options.file] = sha256(read_file(options.file));
    if (!options.tune.empty()) summary["files"][options.tune] = sha256(tune.content());

    if (options.truth.empty()) {
        write_tables(options, page, replayed, summary);
    } else {
        const std::string text = summary.dump(2) + "\n";
        if (!options.out.empty()) write_beside_truth(options, with_engine, replayed, text);
        if (!options.json.empty()) write_file(options.json, text);
    }
    fmt::print("{} events in, {} out\n", replayed.events_in, replayed.replayed_out);
    print_counts(replayed.rows);
    if (replayed.first_difference) {
        fmt::print("events out differ from the recorded {}, first at number {}\n", replayed.recorded_out,
                   *replayed.first_difference);
    } else {
        fmt::print("events out are the recorded ones, bit for bit\n");
    }
    print_contradictions(warnings);
}

} // namespace sixdeg
