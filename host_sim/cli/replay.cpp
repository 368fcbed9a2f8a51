// SPDX-License-Identifier: MIT
// sixdeg replay: a recording of crank edges, or an event log, through the firmware; summary.json, teeth.csv, cycles.csv.
#include "cli/replay_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "design/calibration.hpp"
#include "cli/commands.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "io/log/event_log.hpp"
#include "io/recording/guess.hpp"

namespace sixdeg {

nlohmann::ordered_json figures_json(const ReplayResult &result) {
    const auto or_null = [](const auto &value) { return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(); };
    nlohmann::ordered_json figures;
    figures["edges"] = result.teeth.size();
    figures["revolutions"] = result.revolutions;
    figures["sync_losses"] = result.counts.sync_losses;
    figures["faults_coasted"] = result.counts.coasted + result.counts.spurious;
    figures["first_sync_edge"] = or_null(result.first_sync_edge);
    figures["rpm_last"] = or_null(result.rpm_last);
    return figures;
}

nlohmann::ordered_json decoder_json(const ReplayResult &result) {
    return {{"sync_gains", result.counts.sync_gains}, {"teeth_coasted", result.counts.coasted},
            {"edges_left_out", result.counts.spurious}, {"slips_corrected", result.counts.slips},
            {"marks_missed", result.counts.marks_missed}, {"stalls", result.counts.stalls},
            {"cam_edges_rejected", result.counts.cam_rejected}, {"mark_spacings", result.mark_spacings}};
}

void print_counts(const ReplayResult &result) {
    fmt::print("{} edges, {} whole revolutions, sync at edge {}, {} losses, {} faults coasted through\n", result.teeth.size(),
               result.revolutions, result.first_sync_edge ? std::to_string(*result.first_sync_edge) : std::string("none"),
               result.counts.sync_losses, result.counts.coasted + result.counts.spurious);
    if (result.rpm_last) fmt::print("{:.1f} rpm in the last revolution\n", *result.rpm_last);
}

void write_replay(const ReplayOptions &options, const nlohmann::ordered_json &summary, const ReplayTables &tables) {
    const std::string text = summary.dump(2) + "\n";
    if (!options.out.empty()) {
        OutputFolder out(options.out);
        out.add("summary.json", text);
        out.add("teeth.csv", tables.teeth_csv);
        out.add("cycles.csv", tables.cycles_csv);
        out.commit();
    }
    if (!options.json.empty()) write_file(options.json, text);
}

namespace {

/// What a recording says of an engine nobody described: its wheel, and no more.
EngineFile nameless_engine(const Wheel &wheel) {
    EngineFile engine;
    engine.name = "not given";
    engine.guessed = {"crank.inertia_kgm2", "cylinders"};
    engine.firing_order = {1, 2, 3, 4};
    engine.firing_tdc_deg = {0, 180, 360, 540};
    engine.bore_m = engine.stroke_m = 0.09;
    engine.rod_m = 0.15;
    engine.inertia_kgm2 = 0.2;
    engine.wheel = wheel;
    engine.tick_hz = 1e7;
    return engine;
}

/// Everything that went into a run, kept for the summary.
struct Inputs {
    Recording recording;
    Guess guess;
    EngineFile engine;
    sd_parameters_t tune;
    nlohmann::ordered_json files;
    std::vector<std::string> assumptions;
};

std::vector<std::string> list_assumptions(const Inputs &inputs, bool engine_given) {
    const EngineFile &engine = inputs.engine;
    std::vector<std::string> list;
    if (!engine_given) {
        list.push_back(fmt::format("no engine file: a four-cylinder with constant inertia {:g} kg m2 is assumed, so torque is in proportion only", engine.inertia_kgm2));
    } else {
        for (const std::string &field : engine.guessed) list.push_back("engine: " + field + " is a guess");
        list.push_back(fmt::format("torque is in proportion to the inertia, {:g} kg m2 in the engine file", engine.inertia_kgm2));
    }
    if (!engine.has_cam || !inputs.guess.cam) list.push_back("no cam edge: which revolution of the cycle comes first is arbitrary, cylinders are invalid");
    else list.push_back("no intake pressure in the recording, 1 bar is taken: only differences between cylinders count");
    return list;
}

Inputs read_inputs(const ReplayOptions &options) {
    Inputs inputs;
    inputs.recording = read_recording(options.file);
    inputs.files[options.file] = sha256(read_file(options.file));
    Constraints known;
    if (!options.wheel.empty()) known.wheel = parse_wheel(options.wheel, "--wheel");
    if (!options.edge.empty()) known.edge = parse_edge(options.edge, "--edge");
    if (options.column != 0) known.column = options.column;
    if (!options.engine.empty()) {
        TomlFile file{std::filesystem::path(options.engine)};
        inputs.engine = read_engine(file);
        file.finish();
        inputs.files[options.engine] = sha256(file.content());
        if (!known.wheel) known.wheel = inputs.engine.wheel;
        if (!known.edge) known.edge = inputs.engine.falling_edge ? Edge::falling : Edge::rising;
    }
    inputs.guess = guess(inputs.recording, known);
    if (options.engine.empty()) inputs.engine = nameless_engine(inputs.guess.wheel);
    inputs.engine.wheel = inputs.guess.wheel;

    TomlFile tune = open_tune(options.tune, options.set, options.number);
    inputs.tune = read_tune(tune);
    if (!options.tune.empty()) inputs.files[options.tune] = sha256(tune.content());
    inputs.assumptions = list_assumptions(inputs, !options.engine.empty());
    return inputs;
}

nlohmann::ordered_json summarise(const Inputs &inputs, const ReplayResult &result) {
    nlohmann::ordered_json summary = figures_json(result);
    summary["guess"] = {{"wheel", describe(inputs.guess.wheel)}, {"edge", to_string(inputs.guess.edge)},
                        {"column", inputs.guess.column}, {"gap_ratio", inputs.guess.gap_ratio},
                        {"cam_column", inputs.guess.cam ? nlohmann::ordered_json(inputs.guess.cam->column) : nlohmann::ordered_json()}};
    summary["decoder"] = decoder_json(result);
    summary["engine"] = {{"name", inputs.engine.name}, {"guessed", inputs.engine.guessed}};
    summary["parameters"] = parameters_json(inputs.tune);
    summary["files"] = inputs.files;
    summary["assumptions"] = inputs.assumptions;
    return summary;
}

void print_figures(const Inputs &inputs, const ReplayResult &result) {
    fmt::print("{}\n", describe(inputs.guess));
    print_counts(result);
    for (const std::string &assumption : inputs.assumptions) fmt::print("assumed: {}\n", assumption);
}

void run(const ReplayOptions &options) {
    if (!options.truth.empty()) throw InputError(options.file, "--truth", "a recording has none; allowed beside an event log");
    const Inputs inputs = read_inputs(options);
    const sd_calibration_t calibration = calibrate(inputs.engine, inputs.tune, options.tune.empty() ? "tune" : options.tune);
    const bool with_cam = inputs.engine.has_cam && inputs.guess.cam.has_value();
    const ReplayResult result = replay(options.file, inputs.guess.time_s, with_cam ? inputs.guess.cam->time_s : std::vector<double>{}, calibration);
    write_replay(options, summarise(inputs, result), {teeth_csv(result), cycles_csv(result, inputs.engine.firing_order)});
    print_figures(inputs, result);
}

} // namespace

void add_replay(Command &app) {
    auto options = std::make_shared<ReplayOptions>();
    Command command = app.add("replay", "a recording of crank edges, or an event log, through the firmware");
    command.option("FILE", options->file, "edge list, sampled voltages or edge times (docs/recordings.md), or an event log (docs/log.md)").required();
    command.option("--wheel", options->wheel, "like 60-2; guessed otherwise");
    command.option("--edge", options->edge, "falling or rising; guessed otherwise");
    command.option("--column", options->column, "of the crank signal, column 0 is time; guessed otherwise").within(1, 1000000);
    command.option("--engine", options->engine, "engine file (docs/files.md)");
    command.option("--tune", options->tune, "tune file");
    command.settings(options->set, "key=value, over the tune file");
    command.number(options->number);
    command.option("--truth", options->truth, "folder of the run that an event log is of: its truth beside the replay");
    command.output_folder(options->out, "folder for summary.json, teeth.csv and cycles.csv");
    command.option("--json", options->json, "the summary alone");
    command.runs([options] { is_log(options->file) ? replay_event_log(*options) : run(*options); });
}

} // namespace sixdeg
