// SPDX-License-Identifier: MIT
// sixdeg run, sixdeg plant: a scenario's engine and the firmware, in one process or over a bus; summary.json, teeth.csv,
// cycles.csv.
#include "loop/bus_run.hpp"
#include "loop/emulator_feed.hpp"
#include "cli/firing_report.hpp"
#include "cli/misfire_report.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "design/calibration.hpp"
#include "design/kept_pages.hpp"
#include "cli/commands.hpp"
#include "cli/contradictions.hpp"
#include "cli/learned_page.hpp"
#include "cli/run_figures.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "common/progress.hpp"
#include "common/stop.hpp"
#include "io/log/event_log.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string scenario, tune, number, out, json, record, learned, learn;
    std::vector<std::string> set;
    std::optional<std::uint64_t> seed;
    double restart_s = -1; ///< Below 0: it does not.
    std::optional<double> restart() const { return restart_s < 0 ? std::nullopt : std::optional(restart_s); }
    std::string transport = "inproc";
    bool start_ecu = true;
    Pace pace;
    bool nominal = false;
    std::string cache;
    bool no_cache = false;
};

struct Inputs {
    Scenario scenario;
    sd_parameters_t tune;
    std::string tune_name;
    sd_calibration_t calibration;
    std::optional<sd_kept_t> learned;
    std::optional<Scenario> lesson; ///< Instead of `learned`: each calibration learns from it by itself.
    Json files;

    std::optional<sd_kept_t> learned_with(const sd_calibration_t &page) const {
        if (!lesson) return learned;
        const Progress progress("learning from " + lesson->name);
        return run_on_bench(*lesson, page, nullptr).learned;
    }
};

/// --set takes fields of both files: those below an owner of firmware parameters are the tune's.
bool is_parameter(const std::string &assignment) {
    const std::string table = assignment.substr(0, assignment.find_first_of(".="));
    return std::any_of(
        std::begin(sd_parameter_infos), std::end(sd_parameter_infos),
        [&](const sd_signal_info_t &info) { return std::string(info.name).rfind(table + ".", 0) == 0; });
}

/// A scenario to learn from before the run: on its engine, wheel and seed.
std::optional<Scenario> read_lesson(const Options &options, const Scenario &run) {
    const std::filesystem::path path(options.learned);
    if (path.extension() != ".toml") return std::nullopt;
    TomlFile file(path);
    file.set("engine=\"" + std::filesystem::absolute(run.engine_path).string() + "\"");
    Scenario lesson = read_scenario(file, path.parent_path());
    lesson.engine = run.engine, lesson.encoder = run.encoder, lesson.seed = run.seed;
    lesson.trapped_factor = run.trapped_factor, lesson.compression_factor = run.compression_factor;
    return lesson;
}

Inputs read_inputs(const Options &options) {
    Inputs inputs{};
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
    const std::string engine_text = read_file(inputs.scenario.engine_path);
    inputs.files[inputs.scenario.engine_path.string()] = sha256(engine_text);

    TomlFile tune = open_tune(options.tune, of_tune, options.number);
    inputs.tune = read_tune(tune);
    inputs.tune_name = tune.name();
    if (!options.tune.empty()) inputs.files[options.tune] = sha256(tune.content());
    const KeptPages pages(options.no_cache ? "" : options.cache.empty() ? KeptPages::usual_folder() : std::filesystem::path(options.cache));
    inputs.calibration = pages.calibrate(inputs.scenario.engine.shared, engine_text, inputs.tune, tune.name());
    inputs.lesson = read_lesson(options, inputs.scenario);
    if (inputs.lesson) inputs.files[options.learned] = sha256(read_file(options.learned));
    else if (!options.learned.empty()) inputs.learned = read_learned_page(options.learned, inputs.files);
    return inputs;
}

/// What the event log says of itself. With the engine file other parameters can be tried on it.
Json about(const Options &options, const Inputs &inputs) {
    const EngineFile &engine = inputs.scenario.engine.shared;
    return {{"sixdeg", SD_VERSION}, {"command", "run"}, {"name", inputs.scenario.name},
            {"engine", {{"name", engine.name}, {"guessed", engine.guessed}}},
            {"set", options.set}, {"seed", inputs.scenario.seed}, {"files", inputs.files},
            {"engine_file", read_file(inputs.scenario.engine_path)}};
}

/// What the figures rest on beside the parameters.
Json thresholds() {
    return {{"scored_cycles", kScoredCycles},
            {"misfire_true_burned_below", 0.5},
            {"wrong_revolution_beyond_deg", kWrongRevolutionDeg},
            {"health_counted", {{"torque", "valid"}, {"cylinders", "valid, degraded"}}}};
}

/// Where the calibration does not fit what was seen.
std::vector<std::string> warnings_of(const Inputs &inputs, const RunResult &result) {
    return contradictions(inputs.scenario.engine.shared, inputs.calibration.parameters, result.evidence);
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
    summary["sync_losses"] = result.sync_losses;
    summary["wrong_teeth"] = result.wrong_teeth;
    summary["wrong_revolutions"] = result.wrong_revolutions;
    summary["cylinder_cycles"] = result.true_cycles;
    summary["misfires_true"] = result.misfires;
    summary["stalled"] = result.stalled;
    add_figures(summary, result, perturbed);
    const auto bounds = firing_bounds(inputs.scenario, inputs.tune, result);
    summary["misfire"] = misfire_json(result.misfire, separation_bound(inputs.scenario, bounds));
    if (method_of(inputs.tune) != "monitor") summary["misfire"]["monitor"] = beside_json(result.monitor);
    summary["misfire"]["method"] = method_of(inputs.tune);
    if (perturbed) summary["misfire"]["perturbed"] = misfire_json(perturbed->result.misfire, 0);
    summary["firing"] = firing_json(result, bounds);
    if (perturbed) summary["firing"]["perturbed"] = firing_json(perturbed->result, std::nullopt);
    summary["number"] = inputs.calibration.parameters.torque_fixed_point > 0.5f ? "q31" : "f32";
    summary["seed"] = inputs.scenario.seed;
    summary["set"] = options.set;
    summary["parameters"] = parameters_json(inputs.calibration.parameters);
    summary["thresholds"] = thresholds();
    summary["engine"] = {{"name", engine.name}, {"guessed", engine.guessed}};
    summary["warnings"] = warnings_of(inputs, result);
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
    row("sync losses", std::to_string(result.sync_losses));
    row("wrong teeth, revolutions", fmt::format("{}, {}", result.wrong_teeth, result.wrong_revolutions));
    row("cylinder cycles", fmt::format("{} ({} misfires)", result.true_cycles, result.misfires));
    if (result.stalled) row("the engine", "stalled");
    print_accuracy(result, perturbed);
    const auto bounds = firing_bounds(inputs.scenario, inputs.tune, result);
    const std::string method = method_of(inputs.tune);
    print_misfire(("misfire " + method).c_str(), result.misfire, separation_bound(inputs.scenario, bounds));
    if (method != "monitor") print_beside("the monitor beside it", result.monitor);
    if (perturbed) print_misfire("the same, perturbed", perturbed->result.misfire, 0);
    print_firing("single firings over", result, bounds);
    if (perturbed) print_firing("the same, perturbed, over", perturbed->result, std::nullopt);
    print_contradictions(warnings_of(inputs, result));
}

/// The same run with a calibration that is wrong, drawn from the scenario's seed.
PerturbedRun run_perturbed(const Inputs &inputs) {
    const EngineFile &engine = inputs.scenario.engine.shared;
    const Perturbation drawn = draw_perturbation(engine, inputs.scenario.seed);
    const Progress progress("with a wrong calibration");
    const sd_calibration_t page = calibrate(perturbed(engine, drawn), inputs.tune, inputs.tune_name);
    const auto learned = inputs.learned_with(page);
    return {drawn, run_on_bench(inputs.scenario, page, nullptr, learned ? &*learned : nullptr)};
}

using Clock = std::chrono::steady_clock;

bool on_emulator(const Options &options) { return options.transport.rfind("qemu:", 0) == 0; }

void check_transport(const Options &options) {
    const bool in_process = options.transport == "inproc", emulated = on_emulator(options);
    if ((in_process || emulated) && (options.pace.real_time || options.pace.at_most > 0))
        throw InputError("--real-time, --pace", "", "are for a bus; give --transport");
    if (!in_process && !(options.learn + options.learned).empty())
        throw InputError("--learn, --learned", "", "what is learned stays in the ecu over a bus; leave them out");
    if (options.restart() && !in_process && !emulated)
        throw InputError("--restart", "", "the ecu at the other end of a bus is not in this program's hands; kill it");
    if (options.restart() && !options.record.empty())
        throw InputError("--restart, --record", "", "an event log holds one life of an ecu; leave one of them out");
}

/// What there is to say of an ecu that is not in this process: one of the two.
struct Elsewhere {
    BusFigures bus;
    EmulatorFigures controller;
};

BusChoice bus_of(const Options &options) { return {options.transport, options.pace, options.start_ecu}; }

RunResult run_elsewhere(const Options &options, const Inputs &inputs, RunTables *rows, const EventListener &listener, Elsewhere &figures) {
    if (on_emulator(options))
        return run_on_emulator(options.transport, inputs.scenario, inputs.calibration, rows, listener, options.restart(),
                               figures.controller);
    return run_on_bus(bus_of(options), inputs.scenario, inputs.calibration, rows, listener, figures.bus);
}

void add_elsewhere(Json &summary, const Options &options, const Elsewhere &figures, std::size_t unanswered) {
    if (on_emulator(options)) {
        summary["controller"] = emulator_json(figures.controller, unanswered);
        return;
    }
    summary["bus"] = bus_json(bus_of(options), figures.bus);
    summary["bus"]["edges_unanswered"] = unanswered;
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
    check_transport(options);
    const bool in_process = options.transport == "inproc";
    RunTables *const rows = tables ? &*tables : nullptr;
    const auto learned = inputs.learned_with(inputs.calibration);
    const Clock::time_point start = Clock::now();
    Elsewhere elsewhere;
    const RunResult result = in_process ? run_on_bench(inputs.scenario, inputs.calibration, rows, learned ? &*learned : nullptr, listener,
                                                       options.restart())
                                        : run_elsewhere(options, inputs, rows, listener, elsewhere);
    const std::chrono::duration<double> since_start = Clock::now() - start;
    const double realtime_factor = result.simulated_s / (elsewhere.bus.took_s > 0 ? elsewhere.bus.took_s : since_start.count());
    std::optional<PerturbedRun> perturbed;
    if (in_process && !options.nominal) perturbed = run_perturbed(inputs);
    Json about_run = summarise(options, inputs, result, perturbed, realtime_factor);
    if (!in_process) add_elsewhere(about_run, options, elsewhere, result.unanswered);
    const std::string summary = about_run.dump(2) + "\n";
    if (log) log->finish();
    if (tables) {
        OutputFolder out(options.out);
        out.add("summary.json", summary);
        out.add("teeth.csv", tables->teeth_csv());
        out.add("cycles.csv", tables->cycles_csv());
        if (!tables->air_path().empty()) out.add("airpath.csv", tables->air_path().csv());
        out.commit();
    }
    if (!options.json.empty()) write_file(options.json, summary);
    if (!options.learn.empty()) write_file(options.learn, learned_page(result.learned));
    print_figures(inputs, result, perturbed, realtime_factor);
    if (on_emulator(options)) print_emulator(elsewhere.controller, result.unanswered);
    else if (!in_process) print_bus(elsewhere.bus, result.unanswered);
    end_by_signal();
}

void add_options(Command &command, const std::shared_ptr<Options> &options) {
    command.option("SCENARIO", options->scenario, "scenario file (docs/reference/scenario.md)").required();
    command.option("--tune", options->tune, "tune file");
    command.settings(options->set, "key=value, a tune parameter or a scenario field, over the files");
    command.number(options->number);
    command.option("--seed", options->seed, "instead of the scenario's").within_whole(0, std::int64_t(1) << 52);
    command.output_folder(options->out, "folder for summary.json, teeth.csv and cycles.csv");
    command.option("--json", options->json, "the summary alone");
    command.option("--learned", options->learned,
                   "what was learned before, or a scenario whose fuel cut is learned from first (by each calibration for itself); "
                   "not over a bus");
    command.option("--learn", options->learn, "where what was learned goes at the end of the run; not over a bus");
    command.flag("--nominal", options->nominal, "skip the second run, whose calibration is wrong on purpose; over a bus there is none");
    const Option cache = command.option("--cache", options->cache,
                                        "folder of pages seen before, in place of ~/.cache/sixdeg (docs/reference/files.md)");
    command.flag("--no-cache", options->no_cache, "design the page anew, and keep it nowhere").excludes(cache);
    command.option("--record", options->record, "event log of all that goes in and out (docs/reference/log.md)");
    const Option real_time = command.flag("--real-time", options->pace.real_time,
                                          "at the pace of the clock; without it plant and ecu wait for each other");
    command.option("--pace", options->pace.at_most, "waiting for each other, at most so many times real time: for slow listeners")
        .within(0.01, 1000.0)
        .excludes(real_time);
    command.runs([options] { run(*options); });
}

} // namespace

void add_run(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("run", "a scenario's engine and the firmware, in one process or as two over a bus");
    command.task("A simulated engine", "run host_sim/data/scenarios/balance_1000rpm_5bar.toml");
    add_options(command, options);
    command.option("--transport", options->transport,
                   "inproc, can:IFACE, lcm or lcm:URL (docs/reference/bus.md); qemu:CORE, an emulated controller (docs/start/porting.md)");
    command.option("--restart", options->restart_s, "the ecu begins anew at this second; not over a bus").within(0.0, 1e6);
}

void add_plant(Command &app) {
    auto options = std::make_shared<Options>();
    options->start_ecu = false;
    Command command = app.add("plant", "a scenario's engine on a bus, for an ecu that is there");
    command.task("Over a bus", "plant SCENARIO.toml --transport lcm");
    add_options(command, options);
    command.option("--transport", options->transport, "can:IFACE, lcm or lcm:URL (docs/reference/bus.md)").required();
}

} // namespace sixdeg
