// SPDX-License-Identifier: MIT
// sixdeg replay: a recording of crank edges, or an event log, through the firmware; summary.json, teeth.csv, cycles.csv, firings.csv,
// work.csv.
#include "cli/replay_command.hpp"

#include <cmath>
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/contradictions.hpp"
#include "cli/learned_page.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "design/calibration.hpp"
#include "io/log/event_log.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

/// What a recording says of an engine nobody described: its wheel, and no more.
EngineFile nameless_engine() {
    EngineFile engine;
    engine.name = "not given";
    engine.guessed = {"crank.inertia_kgm2", "cylinders"};
    engine.firing_order = {1, 2, 3, 4};
    engine.firing_tdc_deg = {0, 180, 360, 540};
    engine.bore_m = engine.stroke_m = 0.09;
    engine.rod_m = 0.15;
    engine.inertia_kgm2 = 0.2;
    engine.tick_hz = 1e7;
    return engine;
}

/// Everything that went into a run, kept for the summary.
struct Inputs {
    FoundRecording found;
    EngineFile engine;
    bool engine_given = false;
    sd_parameters_t tune{};
    std::string tune_name;
    std::vector<SensorSource> sensors;
    std::optional<sd_kept_t> learned;
    std::optional<int> parity;
    Json files;
    std::vector<std::string> notes;

    bool has(sd_input_t input) const {
        return std::any_of(sensors.begin(), sensors.end(), [&](const SensorSource &s) { return s.input == int(input); });
    }
    bool phase_told() const { return parity.has_value() || (engine.has_cam && found.guess.cam); }
};

std::vector<std::string> list_assumptions(const Inputs &inputs) {
    const EngineFile &engine = inputs.engine;
    std::vector<std::string> list;
    if (!inputs.engine_given) {
        list.push_back(
            fmt::format("no engine file: a four-cylinder with constant inertia {:g} kg m2 is assumed, so torque is in proportion only",
                        engine.inertia_kgm2));
    } else {
        for (const std::string &field : engine.guessed) list.push_back("engine: " + field + " is a guess");
        list.push_back(fmt::format("torque is in proportion to the inertia, {:g} kg m2 in the engine file", engine.inertia_kgm2));
    }
    if (!inputs.phase_told()) list.push_back("no cam edge: which revolution of the cycle comes first is arbitrary, cylinders are invalid");
    else if (!inputs.has(SD_INPUT_AIR_INTAKE_PRESSURE))
        list.push_back("no intake pressure in the recording, 1 bar is taken: only differences between cylinders count");
    if (!inputs.has(SD_INPUT_FUEL_INJECTED)) list.push_back("no injected fuel: misfires are not judged; --fuel gives it");
    return list;
}

void read_engine_and_tune(const ReplayOptions &options, Inputs &inputs) {
    inputs.engine = nameless_engine();
    if (!options.engine.empty()) {
        TomlFile file{std::filesystem::path(options.engine)};
        inputs.engine = read_engine(file);
        file.finish();
        inputs.engine_given = true;
        inputs.files[options.engine] = sha256(file.content());
        protect_input(options.engine);
    }
    TomlFile tune = open_tune(options.tune, options.set, options.number);
    inputs.tune = read_tune(tune);
    inputs.tune_name = options.tune.empty() ? "tune" : options.tune;
    if (options.tune.empty()) return;
    inputs.files[options.tune] = sha256(tune.content());
    protect_input(options.tune);
}

void set_parity(Inputs &inputs, int parity) {
    inputs.parity = parity;
    inputs.found.guess.cam.reset();
    // Without a cam of the engine's any place will do; not beside the mark, where the tooth may be missing.
    if (!inputs.engine.has_cam) inputs.engine.cam_edge_deg = std::fmod(inputs.engine.position_0_deg + 90, 720);
    inputs.engine.has_cam = true;
}

Inputs read_inputs(const ReplayOptions &options) {
    Inputs inputs;
    const TextLayout layout = RowReader(std::filesystem::path(options.file)).layout();
    inputs.files[options.file] = sha256_of_file(options.file);
    protect_input(options.file);
    read_engine_and_tune(options, inputs);
    inputs.found = find_recording(options.file, recording_constraints(options, layout, inputs.engine_given ? &inputs.engine : nullptr));
    inputs.engine.wheel = inputs.found.guess.wheel;
    if (const auto &cam = inputs.found.guess.cam; cam && !cam->file.empty()) inputs.files[cam->file] = sha256_of_file(cam->file);
    inputs.sensors = sensor_sources(options, layout, double(inputs.tune.afr_stoichiometric));
    for (const SensorSource &sensor : inputs.sensors)
        if (!sensor.file.empty()) inputs.files[sensor.file] = sha256_of_file(sensor.file);
    if (!options.learned.empty()) inputs.learned = read_learned_page(options.learned, inputs.files);
    if (!options.parity.empty()) set_parity(inputs, options.parity == "second" ? 1 : 0);
    inputs.notes = notes_of(inputs.found);
    return inputs;
}

/// As many harmonics as the wheel can carry, where the caller names none; nothing where the observers do not take the wheel.
std::optional<sd_calibration_t> page_for(Inputs &inputs) {
    const bool free = inputs.tune.torque_harmonics == 0;
    const float usual = resolve(inputs.engine, inputs.tune).torque_harmonics;
    if (inputs.engine.wheel.positions % 2) {
        inputs.notes.push_back(
            fmt::format("the torque observers take even numbers of positions only, the wheel has {}: angle and speed alone",
                        inputs.engine.wheel.positions));
        return std::nullopt;
    }
    std::optional<InputError> first;
    for (float harmonics = usual; harmonics >= 1; --harmonics) {
        if (free) inputs.tune.torque_harmonics = harmonics;
        try {
            const sd_calibration_t page = calibrate(inputs.engine, inputs.tune, inputs.tune_name);
            if (harmonics < usual)
                inputs.notes.push_back(fmt::format("the torque observer has {:g} harmonics instead of {:g}: no more converge on {}",
                                                   harmonics, usual, describe(inputs.engine.wheel)));
            return page;
        } catch (const InputError &error) {
            if (!free) throw;
            if (!first) first = error;
        }
    }
    if (inputs.engine_given) throw *first;
    inputs.notes.push_back(
        fmt::format("the torque observer converges with no harmonics on {}: angle and speed alone", describe(inputs.engine.wheel)));
    return std::nullopt;
}

ReplayResult run_recording(const ReplayOptions &options, Inputs &inputs, ReplaySink &sink, const std::optional<sd_calibration_t> &page) {
    RecordedEvents events(options.file, inputs.found.guess, inputs.sensors);
    ReplayPlan plan;
    plan.next = [&](RecordedEvent &event) { return events.next(event); };
    plan.positions = inputs.engine.wheel.positions;
    plan.parity = inputs.parity;
    const auto &cam = inputs.found.guess.cam;
    if (cam && cam->teeth > 1) plan.cam_position = cam_position(*cam, inputs.engine.wheel);
    if (inputs.learned) plan.learned = &*inputs.learned;
    if (!page) {
        CrankAlone crank(options.file, inputs.engine, double(inputs.tune.crank_stall_time_s));
        return replay(plan, crank, sink);
    }
    plan.parity_position = page->cam_position;
    return replay(options.file, plan, *page, sink);
}

Json guess_json(const Inputs &inputs) {
    const Guess &guess = inputs.found.guess;
    Json json = {{"wheel", wheel_name(guess)}, {"edge", to_string(guess.edge)}, {"column", guess.column}, {"gap_ratio", guess.gap_ratio},
                 {"runner_up", guess.runner_up}, {"time_unit_s", guess.unit_s}, {"time_origin_s", inputs.found.origin_s},
                 {"threshold", guess.is_edge_times || guess.slicing.is_level ? Json() : Json(guess.slicing.threshold)},
                 {"cam_column", guess.cam ? Json(guess.cam->column) : Json()}, {"cam_teeth", guess.cam ? Json(guess.cam->teeth) : Json()}};
    if (guess.cam) json["cam_deg"] = cam_place_deg(*guess.cam, inputs.engine);
    return json;
}

Json summarise(const Inputs &inputs, const ReplayResult &result) {
    Json summary = figures_json(result);
    summary["guess"] = guess_json(inputs);
    summary["decoder"] = decoder_json(result);
    summary["misfire"] = misfire_json(result, inputs.engine.firing_order);
    summary["engine"] = {{"name", inputs.engine.name}, {"guessed", inputs.engine.guessed}, {"firing_order", inputs.engine.firing_order}};
    summary["inputs"] = {{"intake", inputs.has(SD_INPUT_AIR_INTAKE_PRESSURE)}, {"fuel", inputs.has(SD_INPUT_FUEL_INJECTED)},
                         {"lambda", inputs.has(SD_INPUT_EXHAUST_LAMBDA)}, {"phase", inputs.phase_told()},
                         {"learned", inputs.learned.has_value()}};
    summary["parameters"] = parameters_json(inputs.tune);
    summary["files"] = inputs.files;
    summary["notes"] = inputs.notes;
    summary["assumptions"] = list_assumptions(inputs);
    return summary;
}

void print_misfires(const ReplayResult &result) {
    for (std::size_t i = 0; i < result.misfires.size(); ++i) {
        const MisfireCounts &counts = result.misfires[i];
        if (counts.judged)
            fmt::print("cylinder {}: {} misfires and {} partial burns in {} firings judged\n", i + 1, counts.misfires, counts.partial,
                       counts.judged);
    }
}

void run(const ReplayOptions &options) {
    if (!options.truth.empty()) throw InputError(options.file, "--truth", "a recording has none; allowed beside an event log");
    Inputs inputs = read_inputs(options);
    if (inputs.engine_given && !inputs.parity && !inputs.found.guess.cam) {
        const ParityFound found = find_parity(options.file, inputs.found.guess, inputs.engine, double(inputs.tune.crank_stall_time_s));
        if (found.parity) set_parity(inputs, *found.parity);
        inputs.notes.push_back(found.note);
    }
    const std::optional<sd_calibration_t> page = page_for(inputs);
    ReplayOutput out(options, {inputs.engine.firing_order, double(inputs.tune.afr_stoichiometric), inputs.engine_given});
    const ReplayResult result = run_recording(options, inputs, out.sink(), page);
    for (std::string &note : cam_notes(inputs.found, inputs.engine, result)) inputs.notes.push_back(std::move(note));
    const std::optional<std::string> failure = why_not_followed(inputs.found, result);
    Json summary = summarise(inputs, result);
    const bool judged = inputs.engine_given && page; // a nameless engine fits none
    const auto warnings = judged ? contradictions(inputs.engine, page->parameters, result.evidence) : std::vector<std::string>();
    summary["warnings"] = warnings;
    summary["not_followed"] = failure ? Json(*failure) : Json();
    out.commit(summary);
    if (!options.learn.empty()) write_file(options.learn, learned_page(result.learned));
    fmt::print("{}\n", describe(inputs.found.guess));
    print_counts(result);
    print_misfires(result);
    for (const std::string &note : inputs.notes) fmt::print("note: {}\n", note);
    for (const std::string &assumption : list_assumptions(inputs)) fmt::print("assumed: {}\n", assumption);
    print_contradictions(warnings);
    if (failure) throw NotFollowed(options.file, *failure);
}

} // namespace

void add_replay(Command &app) {
    auto options = std::make_shared<ReplayOptions>();
    Command command = app.add("replay", "a recording of crank edges, or an event log, through the firmware");
    command.task("A recording", "replay FILE --out DIR");
    command.option("FILE", options->file,
                   "edge list, sampled voltages or edge times (docs/start/recordings.md), or an event log (docs/reference/log.md)")
        .required();
    command.option("--wheel", options->wheel, "like 60-2, 36-2-1 or 24+1; guessed otherwise");
    command.option("--edge", options->edge, "falling or rising; guessed otherwise");
    command.option("--column", options->column, "of the crank signal, number from 0 or name; guessed otherwise");
    command.option("--threshold", options->threshold, "of the crank signal, in its own unit; found otherwise");
    command.option("--time-unit", options->time_unit,
                   "seconds of one unit of the times, such as 1e-6; from the header or guessed otherwise");
    command.option("--cam", options->cam, "cam signal: a column (number, name or column:N), or FILE or FILE:COLUMN; guessed otherwise");
    command.option("--parity", options->parity, "without a cam: which revolution of the cycle the first one in sync is, first or second")
        .one_of({"first", "second"});
    command.option("--intake", options->intake, "intake pressure in bar: a number, a column (name or column:N), or FILE or FILE:COLUMN");
    command.option("--fuel", options->fuel, "injected fuel, mg a stroke and cylinder; as --intake");
    command.option("--lambda", options->lambda, "air to fuel over stoichiometric; as --intake");
    command.option("--load", options->load, "torque that the engine works against, N m, added to the work of a cycle; as --intake");
    command.option("--engine", options->engine, "engine file (docs/reference/files.md)");
    command.option("--tune", options->tune, "tune file");
    command.settings(options->set, "key=value, over the tune file");
    command.number(options->number);
    command.option("--learned", options->learned, "what was learned before, as in run");
    command.option("--learn", options->learn, "where what was learned goes at the end");
    command.option("--truth", options->truth, "folder of the run that an event log is of: its truth beside the replay");
    command.output_folder(options->out, "folder for summary.json, teeth.csv, cycles.csv, firings.csv and work.csv");
    command.option("--json", options->json, "the summary alone");
    command.runs([options] { is_log(options->file) ? replay_event_log(*options) : run(*options); });
}

} // namespace sixdeg
