// SPDX-License-Identifier: MIT
// sixdeg identify: a recording and a first engine file to what the recording tells of the engine, and an engine file that says where each
// of its numbers is from.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands.hpp"
#include "cli/recorded_teeth.hpp"
#include "common/error.hpp"
#include "cli/learned_page.hpp"
#include "identify/engine_text.hpp"
#include "identify/identify.hpp"
#include "identify/learned_pattern.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUsualPatternSd = 0.02; // deg, default of firing.pattern_sd (signals.md)

struct Options {
    ReplayOptions recording;
    double bar = 1;
    std::vector<std::string> motored;
    std::string out, json, learn;
};

/// NaN for what is no number.
double number_of(const std::string &text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? value : std::nan("");
}

std::vector<TimeWindow> windows_of(const std::vector<std::string> &texts) {
    std::vector<TimeWindow> windows;
    for (const std::string &text : texts) {
        const std::size_t colon = std::min(text.find(':'), text.size() - 1);
        const TimeWindow window{number_of(text.substr(0, colon)), number_of(text.substr(colon + 1))};
        if (!(window.to_s > window.from_s)) throw InputError("--motored", "", fmt::format("'{}' is not FROM:TO in s, the second later",
            text));
        windows.push_back(window);
    }
    return windows;
}

std::string quoted_list(const std::vector<std::string> &texts) {
    std::string list;
    for (const std::string &text : texts) list += (list.empty() ? "\"" : ", \"") + text + "\"";
    return "[" + list + "]";
}

std::string interval(const Found &found, int digits, const char *unit) {
    return fmt::format("{:.{}f} +-{:.{}f}{} (95 %)", found.value, digits, found.half_width, digits, unit);
}

/// As many digits behind the point as make a hundredth of the half-width show.
int digits_of(const Found &found) {
    int digits = 1;
    for (double step = 0.1; step > found.half_width / 10 && digits < 7; step /= 10) ++digits;
    return digits;
}

struct Line {
    std::string name, unit;
    const Found *found;
};

std::vector<Line> lines_of(const Identified &f) {
    return {{"inertia", " kg m2", &f.inertia_kgm2},
            {"compression over inertia", " of the engine file's", &f.compression_share},
            {"first tooth after the mark", " deg of crank", &f.position_0_deg},
            {"the same by compression alone", " deg of crank", &f.compression_0_deg},
            {"exponent of compression", "", &f.exponent}};
}

void print(const Identified &f, const std::vector<std::string> &notes) {
    fmt::print("{} whole cycles, {} without combustion; {} used\n", f.cycles, f.motored, f.used);
    for (const Line &line : lines_of(f)) {
        if (line.found->told()) fmt::print("{}: {}\n", line.name, interval(*line.found, digits_of(*line.found), line.unit.c_str()));
    }
    double most = 0, half = 0, square = 0, count = 0;
    for (const Found &tooth : f.pattern_deg) {
        if (!tooth.told()) continue;
        most = std::fmax(most, std::abs(tooth.value));
        half = std::fmax(half, tooth.half_width);
        square += tooth.value * tooth.value, count += 1;
    }
    if (count > 0)
        fmt::print("tooth pattern: {:.3f} deg rms, {:.3f} deg at most, each tooth +-{:.3f} deg or less (95 %)\n",
            std::sqrt(square / count), most, half);
    for (const DragAt &drag : f.drag) {
        const Found &told = drag.nm.told() ? drag.nm : drag.over_inertia;
        fmt::print("load and friction at {:.0f} rpm{}: {} from {} cycles\n", drag.rpm, drag.motored ? " without combustion" : "",
            interval(told, 2, drag.nm.told() ? " N m" : " rad/s2 times the inertia"),
                   drag.cycles.size());
    }
    fmt::print("a tooth scatters by {:.4f} deg; {:.4f} deg rms repeat from cycle to cycle without being explained;\n"
               "a torque of {:.1f} % of the gas torque is needed beside it\n", f.scatter_deg, f.unexplained_deg, f.unexplained_percent);
    for (const Line &line : lines_of(f))
        if (!line.found->told() && line.found != &f.compression_share) fmt::print("not told: {}: {}\n", line.name, line.found->refused);
    if (!f.pattern_refused.empty()) fmt::print("not told: tooth pattern: {}\n", f.pattern_refused);
    fmt::print("not told: friction apart from load: the teeth show their sum\n");
    for (const std::string &note : notes) fmt::print("note: {}\n", note);
}

Json json_of(const Found &found) {
    if (!found.told()) return {{"refused", found.refused}};
    return {{"value", found.value}, {"half_width_95", found.half_width}};
}

Json summary(const Identified &f, const std::vector<std::string> &notes) {
    Json json = {{"cycles", f.cycles}, {"motored", f.motored}, {"used", f.used}, {"inertia_kgm2", json_of(f.inertia_kgm2)},
                 {"compression_share", json_of(f.compression_share)}, {"position_0_deg", json_of(f.position_0_deg)},
                 {"compression_0_deg", json_of(f.compression_0_deg)},
                 {"exponent", json_of(f.exponent)}, {"scatter_deg", f.scatter_deg}, {"unexplained_deg", f.unexplained_deg},
                     {"unexplained_percent", f.unexplained_percent}};
    for (const Found &tooth : f.pattern_deg) json["pattern_deg"].push_back(json_of(tooth));
    for (const DragAt &d : f.drag)
        json["drag"].push_back({{"rpm", d.rpm}, {"motored", d.motored}, {"cycles", d.cycles.size()}, {"nm", json_of(d.nm)},
            {"over_inertia_radps2", json_of(d.over_inertia)}});
    json["notes"] = notes;
    return json;
}

/// The fields that were measured, and what the comment behind each says.
std::map<std::string, NewValue> values_of(const Identified &f, const EngineFile &engine, const std::string &recording) {
    std::map<std::string, NewValue> values;
    std::vector<std::string> guessed = engine.guessed;
    const auto put = [&](const std::string &field, const Found &found, const char *unit) {
        if (!found.told()) return;
        const int digits = digits_of(found);
        values[field] = {fmt::format("{:.{}f}", found.value, digits),
                         fmt::format("measured from {}: {}", recording, interval(found, digits, unit))};
        guessed.erase(std::remove(guessed.begin(), guessed.end(), field), guessed.end());
    };
    put("crank.inertia_kgm2", f.inertia_kgm2, " kg m2");
    put("wheel.position_0_deg", f.position_0_deg, " deg");
    const std::string half = "half the 95 % interval of what was measured from " + recording;
    if (f.inertia_kgm2.told())
        values["tolerance.inertia_percent"] = {fmt::format("{:.2f}", 100 * f.inertia_kgm2.half_width / f.inertia_kgm2.value), half};
    if (f.position_0_deg.told()) values["tolerance.wheel_offset_deg"] = {fmt::format("{:.3f}", f.position_0_deg.half_width), half};
    if (guessed.size() != engine.guessed.size()) values["guessed"] = {quoted_list(guessed),
        "what is measured now is not among them any more"};
    return values;
}

/// What has no field in an engine file, and what could not be told.
std::string remarks(const Identified &f, const std::string &recording) {
    std::string text = fmt::format("\n# sixdeg identify, from {}: {} cycles, {} of them without combustion, {} used.\n", recording,
        f.cycles, f.motored, f.used);
    for (const Line &line : lines_of(f)) {
        if (line.found->told()) text += fmt::format("# {}: {}\n", line.name, interval(*line.found, digits_of(*line.found),
            line.unit.c_str()));
        else if (line.found != &f.compression_share) text += fmt::format("# {}: not told: {}\n", line.name, line.found->refused);
    }
    for (const DragAt &drag : f.drag) {
        const Found &told = drag.nm.told() ? drag.nm : drag.over_inertia;
        text += fmt::format("# load and friction at {:.0f} rpm{}: {}\n", drag.rpm, drag.motored ? " without combustion" : "",
            interval(told, 2, drag.nm.told() ? " N m" : " rad/s2 times the inertia"));
    }
    if (!f.pattern_refused.empty()) return text + "# tooth pattern: not told: " + f.pattern_refused + "\n";
    text += "# tooth pattern, deg by which a tooth stands further on, +- half its 95 % interval, by position:\n";
    for (std::size_t p = 0; p < f.pattern_deg.size(); ++p)
        if (f.pattern_deg[p].told()) text += fmt::format("#   {:3} {:+.4f} +-{:.4f}\n", p, f.pattern_deg[p].value,
            f.pattern_deg[p].half_width);
    return text;
}

std::string new_engine(const Identified &f, const EngineFile &engine, const TomlFile &first, const std::string &recording) {
    const std::string text = engine_with(first.name(), first.content(), values_of(f, engine, recording)) + remarks(f, recording);
    TomlFile again("the new engine file", text);
    read_engine(again);
    again.finish();
    return text;
}

/// Anything at all.
bool tells(const Identified &f) {
    return f.position_0_deg.told() || f.inertia_kgm2.told() || !f.drag.empty() || f.pattern_refused.empty();
}

/// The firmware believes a pattern that it knows better than the usual wheel: firing.pattern_sd, by which it takes teeth to be off.
void note_confidence(const Identified &f, std::vector<std::string> &notes) {
    double variance = 0, square = 0, teeth = 0;
    for (const Found &tooth : f.pattern_deg)
        if (tooth.told()) variance += std::pow(tooth.half_width / 1.96, 2), square += tooth.value * tooth.value, teeth += 1;
    const double sd = std::sqrt(variance / teeth), rms = std::sqrt(square / teeth);
    if (sd < kUsualPatternSd) return;
    notes.push_back(fmt::format("the pattern is known to {:.3f} deg only, which the firmware holds for no better than a usual wheel's "
                                "{} deg: give replay and run --set firing.pattern_sd={:.2f} beside --learned",
                                sd, kUsualPatternSd, std::fmin(rms, 1)));
}

void run(Options options) {
    ReplayOptions &recording = options.recording;
    TomlFile file{std::filesystem::path(recording.engine)};
    const EngineFile engine = read_engine(file);
    file.finish();
    if (engine.torsion || engine.dual_mass)
        throw InputError(recording.engine, engine.torsion ? "torsion" : "dual_mass",
            "identify takes a rigid crank only: what twists is not told from torque");
    for (const std::string &path : {recording.file, recording.engine}) protect_input(path);
    for (const std::string &path : {options.json, options.learn, options.out}) check_output(path);
    if (std::isfinite(number_of(recording.pressure))) recording.pressure = "column:" + recording.pressure;
    RecordedTeeth teeth = read_recorded_teeth(recording, options.bar, engine);
    const Identified found = identify(engine, teeth.record, {windows_of(options.motored)}, recording.file);
    // Each text is made before the first one is written.
    const bool any = tells(found);
    const std::string learned = any && !options.learn.empty() ? learned_page(kept_of(found, recording.file)) : "";
    const std::string made = any ? new_engine(found, engine, file, std::filesystem::path(recording.file).filename().string()) : "";
    if (!learned.empty()) note_confidence(found, teeth.notes);
    print(found, teeth.notes);
    if (!options.json.empty()) write_file(options.json, summary(found, teeth.notes).dump(2) + "\n");
    if (!any) throw NotFollowed(recording.file, "tells nothing of the engine: " + found.position_0_deg.refused);
    if (!options.learn.empty()) write_file(options.learn, learned);
    if (!options.out.empty()) write_file(options.out, made);
}

} // namespace

void add_identify(Command &app) {
    auto o = std::make_shared<Options>();
    Command command = app.add("identify", "inertia, wheel, TDC and drag of your engine from a recording (docs/start/own-engine.md)");
    command.task("Your own engine", "identify FILE ENGINE.toml --pressure COLUMN --motored FROM:TO --out NEW.toml");
    command.option("RECORDING", o->recording.file, "crank teeth, as replay takes them (docs/start/recordings.md)").required();
    command.option("ENGINE", o->recording.engine, "first engine file: its geometry counts, the rest may be a guess").required();
    command.option("--pressure", o->recording.pressure,
                   "pressure in the cylinder that fires first in the file: a column (number, name or column:N), or FILE or FILE:COLUMN");
    command.option("--bar", o->bar, "bar of one unit of that column, beside what its header says; its zero is found").within(-1e9, 1e9);
    command.option("--intake", o->recording.intake,
        "intake pressure in bar: a number, a column (name or column:N), or FILE or FILE:COLUMN");
    command.option("--fuel", o->recording.fuel, "injected fuel, as --intake; where it is 0 nothing burns");
    command.option("--motored", o->motored, "FROM:TO in s of the recording: nothing burns there; as often as you like").one_at_a_time();
    command.option("--wheel", o->recording.wheel, "like 60-2; the engine file's otherwise");
    command.option("--edge", o->recording.edge, "falling or rising; the engine file's otherwise");
    command.option("--column", o->recording.column, "of the crank signal, number from 0 or name; guessed otherwise");
    command.option("--threshold", o->recording.threshold, "of the crank signal, in its own unit; found otherwise");
    command.option("--time-unit", o->recording.time_unit, "seconds of one unit of the times; from the header or guessed otherwise");
    command.option("--cam", o->recording.cam, "cam signal: a column (number, name or column:N), or FILE or FILE:COLUMN; guessed otherwise");
    command.option("--parity", o->recording.parity,
        "without a cam: which revolution of the cycle the first one in sync is, first or second")
        .one_of({"first", "second"});
    command.option("--out", o->out, "the new engine file");
    command.option("--learn", o->learn, "the tooth pattern, for --learned of replay and run");
    command.option("--json", o->json, "the figures as JSON");
    command.runs([o] { run(*o); });
}

} // namespace sixdeg
