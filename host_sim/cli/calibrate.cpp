// SPDX-License-Identifier: MIT
// sixdeg calibrate: engine file and tune to the firmware's calibration page, binary and C source.
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "design/calibration.hpp"
#include "cli/commands.hpp"
#include "common/files.hpp"
#include "cli/tune_options.hpp"

namespace sixdeg {
namespace {

struct Options {
    std::string engine, tune, out, json;
    std::vector<std::string> set;
};

void run(const Options &options) {
    TomlFile engine_toml{std::filesystem::path(options.engine)};
    const EngineFile engine = read_engine(engine_toml);
    engine_toml.finish();
    TomlFile tune_toml = open_tune(options.tune, options.set);
    const sd_parameters_t tune = read_tune(tune_toml);
    const auto bytes = page_bytes(calibrate(engine, tune, tune_toml.name()));

    const std::string stem = std::filesystem::path(options.engine).stem().string();
    OutputFolder out(options.out.empty() ? std::filesystem::path(".") : std::filesystem::path(options.out));
    out.add(stem + ".bin", std::string(bytes.begin(), bytes.end()));
    out.add(stem + ".c", page_source(bytes, engine.name));
    out.commit();

    const double radius = observer_radius(engine, resolve(engine, tune));
    const std::string hash = sha256(std::string(bytes.begin(), bytes.end()));
    fmt::print("{}: {} bytes, sha256 {}\n", stem + ".bin", bytes.size(), hash);
    fmt::print("torque observer: error falls to {:.3f} of itself a cycle\n", radius);
    for (const std::string &field : engine.guessed) fmt::print("guessed: {}\n", field);
    if (options.json.empty()) return;
    write_file(options.json, nlohmann::ordered_json{{"engine", engine.name}, {"bytes", bytes.size()}, {"sha256", hash},
                                                    {"observer_radius", radius}, {"guessed", engine.guessed}}.dump(2) + "\n");
}

} // namespace

void add_calibrate(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("calibrate", "engine file to the firmware's calibration page");
    command.task("Your own engine", "calibrate ENGINE.toml --out DIR");
    command.option("ENGINE", options->engine, "engine file (docs/reference/files.md)").required();
    command.option("TUNE", options->tune, "tune file; defaults where it is missing");
    command.settings(options->set, "key=value, over the tune file");
    command.output_folder(options->out, "folder for NAME.bin and NAME.c, default here");
    command.option("--json", options->json, "figures as JSON");
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
