// SPDX-License-Identifier: MIT
// sixdeg study trips: false decisions of the misfire monitor in so many trips of a healthy engine.
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/tune_options.hpp"
#include "design/calibration.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "score/misfire_score.hpp"
#include "studies/trips/misfire_trips.hpp"

namespace sixdeg {
namespace {

struct Options {
    std::string summary, tune;
    std::vector<std::string> set;
    std::uint64_t trips = 10000, revolutions = 40000, seed = 1;
    int cylinders = 4;
};

double figure(const nlohmann::json &summary, const std::string &file, const char *name) {
    const auto misfire = summary.find("misfire");
    if (misfire == summary.end() || !misfire->contains(name) || !(*misfire)[name].is_number())
        throw InputError(file, std::string("misfire.") + name, "is not there; give the summary.json of a run with misfires");
    return (*misfire)[name].get<double>();
}

sd_misfire_config_t monitor_config(const Options &options) {
    sd_calibration_t calibration{};
    TomlFile tune = open_tune(options.tune, options.set);
    calibration.parameters = read_tune(tune);
    calibration.cylinders = std::uint8_t(options.cylinders);
    for (int i = 0; i < options.cylinders; ++i) calibration.firing_order[i] = std::uint8_t(i + 1);
    return sd_calibration_misfire(&calibration, &calibration.parameters);
}

void print_per_trips(const char *name, std::uint64_t hits, std::uint64_t trips) {
    const RateBounds bounds = rate_bounds(hits, trips);
    fmt::print("  {:<32}{} of {} trips: {:.2f} in 10,000 (95 %: {:.2f} to {:.2f})\n", name, hits, trips, 1e4 * double(hits) / double(trips),
               1e4 * bounds.low, 1e4 * bounds.high);
}

/// How likely a window of `firings` exceeds `percent` by chance at the false alarm rate p, as a power of ten.
void print_window(const char *name, double firings, double percent, double p) {
    const auto most = std::uint64_t(std::floor(percent / 100 * firings));
    double more = 0; // the terms fall fast
    for (std::uint64_t k = most + 1; k <= std::uint64_t(firings) && k <= most + 200; ++k) {
        const double x = double(k);
        more += std::exp(std::lgamma(firings + 1) - std::lgamma(x + 1) - std::lgamma(firings - x + 1) + x * std::log(p) +
                         (firings - x) * std::log1p(-p));
    }
    fmt::print("  {:<32}over {} of {:.0f}: probability {}\n", name, most, firings, more > 0 ? fmt::format("{:.1e}", more) : "below 1e-300");
}

void run(const Options &options) {
    const auto summary = nlohmann::json::parse(read_file(options.summary), nullptr, false);
    const double healthy = figure(summary, options.summary, "index_healthy_sd"),
        stated = figure(summary, options.summary, "index_missed_sd");
    const sd_misfire_config_t config = monitor_config(options);
    const TripFigures f = run_trips(config, {healthy, stated, options.trips, options.revolutions, options.seed});
    const double rate = double(f.false_alarms) / double(f.firings);
    fmt::print("healthy index                     1 with deviation {:.4f}, stated {:.4f}\n", healthy, stated);
    fmt::print("trips                             {} of one start and {} revolutions\n", options.trips, options.revolutions);
    fmt::print("  {:<32}{} of {}: {:.4f} %\n", "false alarms", f.false_alarms, f.firings, 100 * rate);
    fmt::print("  {:<32}{} of 200 revolutions, {} of 1000\n", "windows over their limit", f.windows_200, f.windows_1000);
    print_per_trips("false pending", f.pending, options.trips);
    print_per_trips("false lamp", f.lamp, options.trips);
    if (!(rate > 0)) return;
    print_window("a window of 200 by chance", 100.0 * config.cylinders, double(config.catalyst_percent), rate);
    print_window("a window of 1000 by chance", 500.0 * config.cylinders, double(config.emission_percent), rate);
}

} // namespace

void add_study_trips(Command &study) {
    auto options = std::make_shared<Options>();
    Command command = study.add("trips", "false decisions of the misfire monitor in many trips of a healthy engine");
    command.option("SUMMARY", options->summary, "summary.json of a run with misfires (docs/results/misfire.md)").required();
    command.option("--trips", options->trips, "how many").within_whole(1, 10000000);
    command.option("--revolutions", options->revolutions, "of a trip").within_whole(10, 10000000);
    command.option("--cylinders", options->cylinders, "of the engine").within(1, SD_MISFIRE_CYLINDERS_MAX);
    command.option("--seed", options->seed, "of the firings");
    command.option("--tune", options->tune, "tune file");
    command.settings(options->set, "key=value, a tune parameter");
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
