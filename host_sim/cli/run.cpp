// SPDX-License-Identifier: MIT
// sixdeg run: a scenario's engine and the firmware in one process; summary.json, teeth.csv, cycles.csv.
#include "run/bench_run.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/calibration.hpp"
#include "cli/commands.hpp"
#include "cli/run_figures.hpp"
#include "cli/tune_options.hpp"
#include "common/files.hpp"
#include "common/stop.hpp"
#include "log/event_log.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string scenario, tune, number, out, json, record;
    std::vector<std::string> set;
    std::optional<std::uint64_t> seed;
    bool nominal = false;
};

struct Inputs {
    Scenario scenario;
    sd_parameters_t tune;
    std::string tune_name;
    sd_calibration_t calibration;
    Json files;
};

/// --set takes fields of both files: those below an owner of firmware parameters are the tune's.
bool is_parameter(const std::string &assignment) {
    const std::string table = assignment.substr(0, assignment.find_first_of(".="));
    return std::any_of(
        std::begin(sd_parameter_infos), std::end(sd_parameter_infos),
        [&](const sd_signal_info_t &info) { return std::string(info.name).rfind(table + ".", 0) == 0; });
}

Inputs read_inputs(const Options &options) {
    Inputs inputs;
    std::vector<std::string> of_scenario = options.set;
    const auto first = std::stable_partition(of_scenario.begin(), of_scenario.end(),
                                             [](const auto &a) { return !is_parameter(a); });
    const std::vector<std::string> of_tune(first, of_scenario.end());
    of_scenario.erase(first, of_scenario.end());

    const std::filesystem::path path(options.scenario);
    TomlFile file(path);
    for (const std::string &assignment : of_scenario) file.set(assignment);
    inputs.scenario = read_scenario(file, path.parent_path());
    if (options.seed) inputs.scenario.seed = *options.seed;
    inputs.files[options.scenario] = sha256(file.content());
    inputs.files[inputs.scenario.engine_path.string()] = sha256(read_file(inputs.scenario.engine_path));

    TomlFile tune = open_tune(options.tune, of_tune, options.number);
    inputs.tune = read_tune(tune);
    inputs.tune_name = tune.name();
    if (!options.tune.empty()) inputs.files[options.tune] = sha256(tune.content());
    inputs.calibration = calibrate(inputs.scenario.engine.shared, inputs.tune, tune.name());
    return inputs;
}

/// What the event log says of itself; truth is no part of it.
Json about(const Options &options, const Inputs &inputs) {
    const EngineFile &engine = inputs.scenario.engine.shared;
    return {{"sixdeg", SD_VERSION}, {"command", "run"}, {"name", inputs.scenario.name},
            {"engine", {{"name", engine.name}, {"guessed", engine.guessed}}},
            {"set", options.set}, {"seed", inputs.scenario.seed}, {"files", inputs.files}};
}

/// What the figures rest on beside the parameters.
Json thresholds() {
    return {{"scored_cycles", kScoredCycles},
            {"misfire_true_burned_below", 0.5},
            {"wrong_revolution_beyond_deg", kWrongRevolutionDeg},
            {"health_counted", {{"torque", "valid"}, {"cylinders", "valid, degraded"}}}};
}

Json summarise(const Options &options, const Inputs &inputs, const RunResult &result,
               const std::optional<PerturbedRun> &perturbed, double realtime_factor) {
    const EngineFile &engine = inputs.scenario.engine.shared;
    Json summary;
    summary["scenario"] = inputs.scenario.name;
    summary["simulated_s"] = result.simulated_s;
    summary["realtime_factor"] = realtime_factor;
    summary["edges"] = result.edges;
    summary["false_edges"] = result.false_edges;
    summary["sync_losses"] = result.counts.sync_losses;
    summary["wrong_teeth"] = result.wrong_teeth;
    summary["wrong_revolutions"] = result.wrong_revolutions;
    summary["cylinder_cycles"] = result.true_cycles;
    summary["misfires_true"] = result.misfires;
    summary["stalled"] = result.stalled;
    add_figures(summary, result, perturbed);
    summary["number"] = inputs.calibration.parameters.torque_fixed_point > 0.5f ? "q31" : "f32";
    summary["seed"] = inputs.scenario.seed;
    summary["set"] = options.set;
    summary["parameters"] = parameters_json(inputs.calibration.parameters);
    summary["thresholds"] = thresholds();
    summary["engine"] = {{"name", engine.name}, {"guessed", engine.guessed}};
    summary["versions"] = {{"sixdeg", SD_VERSION}, {"signals", fmt::format("{:08x}", SD_SIGNALS_SIGNATURE)}};
    summary["files"] = inputs.files;
    return summary;
}

void print_figures(const Inputs &inputs, const RunResult &result, const std::optional<PerturbedRun> &perturbed,
                   double realtime_factor) {
    const auto row = [](const char *name, const std::string &value) {
        fmt::print("{:<34}{}\n", name, value);
    };
    fmt::print("{}\n",
               inputs.scenario.name.empty() ? inputs.scenario.engine.shared.name : inputs.scenario.name);
    row("simulated", fmt::format("{:.3f} s, {:.0f} times real time", result.simulated_s, realtime_factor));
    row("crank edges", fmt::format("{} ({} false)", result.edges, result.false_edges));
    row("sync losses", std::to_string(result.counts.sync_losses));
    row("wrong teeth, revolutions", fmt::format("{}, {}", result.wrong_teeth, result.wrong_revolutions));
    row("cylinder cycles", fmt::format("{} ({} misfires)", result.true_cycles, result.misfires));
    if (result.stalled) row("the engine", "stalled");
    print_accuracy(result, perturbed);
}

/// The same run with a calibration that is wrong, drawn from the scenario's seed.
PerturbedRun run_perturbed(const Inputs &inputs) {
    const EngineFile &engine = inputs.scenario.engine.shared;
    const Perturbation drawn = draw_perturbation(engine, inputs.scenario.seed);
    const sd_calibration_t page = calibrate(perturbed(engine, drawn), inputs.tune, inputs.tune_name);
    return {drawn, run_on_bench(inputs.scenario, page, nullptr)};
}

void run(const Options &options) {
    const Inputs inputs = read_inputs(options);
    std::optional<RunTables> tables;
    if (!options.out.empty()) tables.emplace(inputs.scenario.engine.shared);
    std::optional<LogWriter> log;
    if (!options.record.empty()) log.emplace(options.record, about(options, inputs).dump(), inputs.calibration);
    EventListener listener;
    if (log) listener = [&](bool out, const sd_event_t &event) { log->add(out, event); };
    stop_on_signals();
    const auto start = std::chrono::steady_clock::now();
    const RunResult result = run_on_bench(inputs.scenario, inputs.calibration, tables ? &*tables : nullptr, listener);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const double realtime_factor = result.simulated_s / took.count();
    std::optional<PerturbedRun> perturbed;
    if (!options.nominal) perturbed = run_perturbed(inputs);
    const std::string summary = summarise(options, inputs, result, perturbed, realtime_factor).dump(2) + "\n";
    if (log) log->finish();
    if (tables) {
        OutputFolder out(options.out);
        out.add("summary.json", summary);
        out.add("teeth.csv", tables->teeth_csv());
        out.add("cycles.csv", tables->cycles_csv());
        out.commit();
    }
    if (!options.json.empty()) write_file(options.json, summary);
    print_figures(inputs, result, perturbed, realtime_factor);
    end_by_signal();
}

} // namespace

void add_run(CLI::App &app) {
    auto options = std::make_shared<Options>();
    CLI::App *command = app.add_subcommand("run", "a scenario's engine and the firmware in one process");
    command->add_option("SCENARIO", options->scenario, "scenario file (docs/scenario.md)")->required();
    command->add_option("--tune", options->tune, "tune file");
    command
        ->add_option("--set", options->set, "key=value, a tune parameter or a scenario field, over the files")
        ->allow_extra_args(false);
    command->add_option("--number", options->number, "f32 or q31")->check(CLI::IsMember({"f32", "q31"}));
    command->add_option("--seed", options->seed, "instead of the scenario's")
        ->check(CLI::Range(std::uint64_t(0), std::uint64_t(1) << 52));
    command->add_option("--out", options->out, "folder for summary.json, teeth.csv and cycles.csv");
    command->add_option("--json", options->json, "the summary alone");
    command->add_flag("--nominal", options->nominal, "skip the second run, whose calibration is wrong on purpose");
    command->add_option("--record", options->record, "event log of all that goes in and out (docs/log.md)");
    command->callback([options] { run(*options); });
}

} // namespace sixdeg
