// SPDX-License-Identifier: MIT
// sixdeg ecu: the firmware as a process of its own on a bus.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "bus/ecu_process.hpp"
#include "calibration/calibration.hpp"
#include "cli/commands.hpp"
#include "cli/tune_options.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "common/stop.hpp"

namespace sixdeg {
namespace {

struct Options {
    std::string file, transport, tune, number;
    std::vector<std::string> set;
};

/// A page as it is, or the page of an engine file and a tune.
sd_calibration_t read_calibration(const Options &options) {
    const std::string content = read_file(options.file);
    if (content.rfind("SDC1", 0) == 0) {
        sd_calibration_t page;
        const auto *bytes = reinterpret_cast<const std::uint8_t *>(content.data());
        if (sd_calibration_decode(&page, bytes, std::uint32_t(content.size())) == SD_OK) return page;
        throw InputError(options.file, "", "the calibration page is damaged, or of another table of signals");
    }
    TomlFile engine_toml{std::filesystem::path(options.file)};
    const EngineFile engine = read_engine(engine_toml);
    engine_toml.finish();
    TomlFile tune = open_tune(options.tune, options.set, options.number);
    const sd_parameters_t parameters = read_tune(tune);
    return calibrate(engine, parameters, tune.name());
}

void run(const Options &options) {
    const sd_calibration_t calibration = read_calibration(options);
    stop_on_signals();
    run_ecu(*open_bus(options.transport, SD_ROLE_ECU), options.transport, calibration);
}

} // namespace

void add_ecu(CLI::App &app) {
    auto options = std::make_shared<Options>();
    CLI::App *command = app.add_subcommand("ecu", "the firmware as a process of its own on a bus");
    command->add_option("ENGINE", options->file, "engine file, or a calibration page")->required();
    command->add_option("--transport", options->transport, "can:IFACE, lcm or lcm:URL (docs/bus.md)")->required();
    command->add_option("--tune", options->tune, "tune file");
    command->add_option("--set", options->set, "key=value, over the tune file")->allow_extra_args(false);
    command->add_option("--number", options->number, "f32 or q31")->check(CLI::IsMember({"f32", "q31"}));
    command->callback([options] { run(*options); });
}

} // namespace sixdeg
