// SPDX-License-Identifier: MIT
// sixdeg sensors: which sets of sensors observe the wanted states, how soon, at what cost and how well.
#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <memory>

#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "studies/sensor_sets/report.hpp"

namespace sixdeg {
namespace {

struct Options {
    std::string model, json_file;
    std::vector<std::string> targets;
    int size = 0; ///< 0 = not given.
    bool all = false, numeric = false;
    std::size_t top = 10;
    int draws = 2;
    std::uint64_t seed = 1;
};

// More sets than this would take minutes and gigabytes.
constexpr double most_sets = 2e6;

SetQuery query_of(const Options &options, const SensorModel &model) {
    SetQuery query;
    query.targets = options.targets.empty() ? model.targets : model.find_states(options.targets, "--target");
    const int sensors = int(model.sensors.size());
    if (options.size > sensors) {
        throw InputError(
            "--size", "",
            fmt::format("{} is outside [1, {}], the model's number of sensors", options.size, sensors));
    }
    const int otherwise = options.all ? sensors : std::min(3, sensors);
    query.most = options.size ? options.size : otherwise;
    query.least = options.all ? 1 : query.most;
    query.draws_per_prime = options.draws;
    query.seed = options.seed;
    const double sets = count_sets(model.sensors.size(), query.least, query.most);
    if (sets > most_sets)
        throw InputError("--size", "", fmt::format("asks for {:.0f} sets, at most {:.0f}", sets, most_sets));
    return query;
}

void check_numeric(const Options &options, const SensorModel &model, const NumericModel &numeric,
                   const SetQuery &query) {
    if (numeric.points.empty()) throw InputError(options.model, "numeric", "is missing; --numeric needs it");
    const double sets = count_sets(model.sensors.size(), query.least, query.most);
    if (sets > most_studied_sets) {
        throw InputError("--numeric", "",
                         fmt::format("asks for {:.0f} sets, at most {:.0f}", sets, most_studied_sets));
    }
}

// Times go to stderr so that the page itself is the same from run to run.
template <class Work> auto timed(const char *what, Work &&work) {
    const auto start = std::chrono::steady_clock::now();
    auto result = work();
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
    std::fprintf(stderr, "%s: %.1f ms\n", what, spent.count());
    return result;
}

void run(const Options &options) {
    TomlFile file{std::filesystem::path(options.model)};
    const SensorModel model = read_sensor_model(file);
    const NumericModel numeric = read_numeric_model(file, model);
    file.finish();
    const SetQuery query = query_of(options, model);
    if (options.numeric) check_numeric(options, model, numeric, query);
    std::vector<IndexedSets> by_regime;
    for (const auto &regime : model.regimes) {
        const std::string what =
            fmt::format("exact index of all sets, {}, {} draws", regime.name, 2 * query.draws_per_prime);
        by_regime.push_back(timed(what.c_str(), [&] { return index_sets(model, regime.structure, query); }));
    }
    Findings findings = find(model, query, by_regime);
    if (options.numeric) {
        findings.study =
            timed("numeric study", [&] { return study(model, numeric, findings.ranking, query.targets); });
        findings.numeric = &numeric;
    }
    if (!options.json_file.empty()) write_file(options.json_file, json(findings).dump(1) + "\n");
    std::fputs(text(findings, options.top).c_str(), stdout);
}

} // namespace

void add_sensors(Command &app) {
    const auto options = std::make_shared<Options>();
    Command command = app.add("sensors", "rank sensor sets by how soon they reveal the wanted states");
    command.task("Your own engine", "sensors host_sim/data/models/turbo_si_13.toml --size 3");
    command.option("MODEL", options->model, "model structure, for example host_sim/data/models/turbo_si_13.toml").required();
    command.option("--target", options->targets,
                     "states wanted, separated by commas (default: the model's)").separated_by(',');
    command.option("--size", options->size, "sensors in a set (default 3)").within(1, 24);
    command.flag("--all", options->all,
                      "every number of sensors from 1 up to --size, or up to all of them");
    command.flag("--numeric", options->numeric,
                      "also rank with the model's numbers: numeric index, Kalman filter");
    command.option("--top", options->top, "sets to list (default 10)").within(0, 1000);
    command.option("--draws", options->draws, "random draws for each prime (default 2)").within(1, 20);
    command.option("--seed", options->seed, "seed of the draws (default 1)");
    command.option("--json", options->json_file, "write everything found to this file");
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
